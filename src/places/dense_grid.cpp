// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/dense_grid.h"

#include <limits>

namespace tsg::places {
namespace {

constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();

/// One-dimensional transform of a line of cells: lower envelope of the parabolas
/// (p - q)^2 + squared[q] [Felzenszwalb12, Algorithm 1].
class LineTransform {
 public:
  explicit LineTransform(int max_size)
      : squared_(max_size), source_(max_size), apex_(max_size), begin_(max_size) {}

  void run(NearestField& field, std::size_t start, std::size_t stride, int size) {
    for (int q = 0; q < size; ++q) {
      squared_[q] = field.squared_cells[start + static_cast<std::size_t>(q) * stride];
      source_[q] = field.source[start + static_cast<std::size_t>(q) * stride];
    }
    const int num_parabolas = buildEnvelope(size);
    if (num_parabolas == 0) return;
    for (int p = 0, k = 0; p < size; ++p) {
      while (k + 1 < num_parabolas && begin_[k + 1] < p) ++k;
      const int q = apex_[k];
      field.squared_cells[start + static_cast<std::size_t>(p) * stride] =
          (p - q) * (p - q) + squared_[q];
      field.source[start + static_cast<std::size_t>(p) * stride] = source_[q];
    }
  }

 private:
  int buildEnvelope(int size) {
    int count = 0;
    for (int q = 0; q < size; ++q) {
      if (squared_[q] == kFar) continue;
      double from = -std::numeric_limits<double>::infinity();
      for (; count > 0; --count) {
        from = computeCrossing(apex_[count - 1], q);
        if (from > begin_[count - 1]) break;
      }
      apex_[count] = q;
      begin_[count] = count == 0 ? -std::numeric_limits<double>::infinity() : from;
      ++count;
    }
    return count;
  }

  /// Where the parabola at q > v gets below the one at v.
  double computeCrossing(int v, int q) const {
    const double at_q = static_cast<double>(squared_[q]) + static_cast<double>(q) * q;
    const double at_v = static_cast<double>(squared_[v]) + static_cast<double>(v) * v;
    return (at_q - at_v) / (2.0 * (q - v));
  }

  Eigen::VectorXi squared_;
  Eigen::VectorXi source_;
  Eigen::VectorXi apex_;   ///< where each parabola of the envelope has its minimum
  Eigen::VectorXd begin_;  ///< from where on it is the lowest
};

void transformAxis(const GridExtent& extent, int axis, NearestField& field) {
  const int size = extent.size[axis];
  if (size <= 1) return;
  LineTransform line(size);
  GridIndex step = GridIndex::Zero();
  step[axis] = 1;
  const std::size_t stride = extent.toLinear(extent.min + step);
  const std::size_t period = stride * static_cast<std::size_t>(size);
  for (std::size_t first = 0; first < extent.numCells(); first += period) {
    for (std::size_t i = 0; i < stride; ++i) line.run(field, first + i, stride, size);
  }
}

}  // namespace

NearestField computeNearestField(const GridExtent& extent, const std::vector<char>& is_source,
                                 double max_cells) {
  NearestField field;
  field.source.assign(extent.numCells(), NearestField::kNone);
  field.squared_cells.assign(extent.numCells(), kFar);
  for (std::size_t cell = 0; cell < is_source.size(); ++cell) {
    if (is_source[cell] == 0) continue;
    field.source[cell] = static_cast<std::int32_t>(cell);
    field.squared_cells[cell] = 0;
  }
  for (int axis = 0; axis < 3; ++axis) transformAxis(extent, axis, field);
  for (std::size_t cell = 0; cell < is_source.size(); ++cell) {
    if (static_cast<double>(field.squared_cells[cell]) <= max_cells * max_cells) continue;
    field.source[cell] = NearestField::kNone;
    field.squared_cells[cell] = kFar;
  }
  return field;
}

}  // namespace tsg::places

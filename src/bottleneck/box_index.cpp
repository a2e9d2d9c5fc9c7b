// SPDX-License-Identifier: BSD-3-Clause
#include "box_index.h"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/iterator/function_output_iterator.hpp>
#include <iterator>

namespace tsg::bottleneck {
namespace {

namespace bg = boost::geometry;
namespace bgi = boost::geometry::index;
using Point = bg::model::point<double, 3, bg::cs::cartesian>;
using Box = bg::model::box<Point>;
using Value = std::pair<Box, std::uint32_t>;
using Rtree = bgi::rtree<Value, bgi::quadratic<16>>;

Box toBox(const Aabb& box) {
  return Box(Point(box.min().x(), box.min().y(), box.min().z()),
             Point(box.max().x(), box.max().y(), box.max().z()));
}

Aabb fromBox(const Box& box) {
  const Point& a = box.min_corner();
  const Point& b = box.max_corner();
  return makeAabb({a.get<0>(), a.get<1>(), a.get<2>()}, {b.get<0>(), b.get<1>(), b.get<2>()});
}

}  // namespace

struct BoxIndex::Tree {
  Rtree rtree;
};

BoxIndex::BoxIndex() : tree_(std::make_unique<Tree>()) {}
BoxIndex::~BoxIndex() = default;
BoxIndex::BoxIndex(BoxIndex&&) noexcept = default;
BoxIndex& BoxIndex::operator=(BoxIndex&&) noexcept = default;

void BoxIndex::insert(const std::vector<Entry>& entries) {
  std::vector<Value> values;
  values.reserve(entries.size());
  for (const auto& [box, id] : entries) {
    if (!box.isEmpty()) values.emplace_back(toBox(box), id);
  }
  if (values.size() <= tree_->rtree.size()) {
    tree_->rtree.insert(values.begin(), values.end());
    return;
  }
  values.insert(values.end(), tree_->rtree.begin(), tree_->rtree.end());
  tree_->rtree = Rtree(values.begin(), values.end());
}

void BoxIndex::remove(const Entry& entry) {
  if (!entry.first.isEmpty()) tree_->rtree.remove(Value(toBox(entry.first), entry.second));
}

std::vector<std::uint32_t> BoxIndex::findOverlapping(const Aabb& box) const {
  std::vector<std::uint32_t> ids;
  if (box.isEmpty()) return ids;
  ids.reserve(32);
  tree_->rtree.query(bgi::intersects(toBox(box)),
                     boost::make_function_output_iterator([&](const Value& hit) {
                       if (hasOverlap(box, fromBox(hit.first))) ids.push_back(hit.second);
                     }));
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace tsg::bottleneck

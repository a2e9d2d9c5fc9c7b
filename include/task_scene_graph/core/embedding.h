// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace tsg {

/// A vector in the joint image-text space (D floats). An empty vector means "no embedding".
using Embedding = Eigen::VectorXf;

/// One embedding per row (rows x D, row-major, as the networks write them and messages carry them).
using EmbeddingMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// True if every value is finite and at least one is not 0.
inline bool hasDirection(const Embedding& embedding) {
  return embedding.allFinite() && (embedding.array() != 0.0F).any();
}

/// Cosine of the angle between two vectors of the same length, in [-1, 1]; 0 if either is zero.
template <typename A, typename B>
double computeCosine(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  const double norms = static_cast<double>(a.norm()) * static_cast<double>(b.norm());
  if (!(norms > 0.0)) return 0.0;
  return static_cast<double>(a.dot(b)) / norms;
}

}  // namespace tsg

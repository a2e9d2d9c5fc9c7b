// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/container/small_vector.hpp>
#include <cstdint>

// clang-format off
/// Symbols of [Clio24, Sec. III] as this module uses them. All logarithms have base 2 (bits), and
/// 0 log 0 = 0.
///
/// | paper        | here                   | meaning                                             |
/// | ------------ | ---------------------- | --------------------------------------------------- |
/// | x, X, N      | primitive, N           | task-agnostic primitives, and how many              |
/// | x~, n_i      | cluster, count         | a set of primitives, and how many it holds          |
/// | y, m         | task, M                | 0 is the null task t_0, task j of the list is y = j |
/// | phi, theta   | scores                 | cosine of primitive and task; [alpha, phi_1..phi_m] |
/// | p(y given x) | relevance              | Eq. 5, sparse: only the support is stored           |
/// |              | masses m_i(y)          | sum of p(y given x) over the cluster's primitives   |
/// | d_ij         | d = D / N              | Eq. 2, the information that a merge loses           |
/// |              | D, cost                | N d_ij = (n_i + n_j) JS, independent of N           |
/// | delta(k)     | delta = D / (N I(X;Y)) | Eq. 3, the loss counted positive                    |
// clang-format on
namespace tsg::bottleneck {

/// One entry of a sparse vector over tasks.
struct TaskMass {
  std::uint32_t task = 0;  ///< y: 0 = null, j = task j - 1 of the list
  double mass = 0.0;       ///< > 0; a probability where the vector sums to 1

  friend bool operator==(TaskMass a, TaskMass b) { return a.task == b.task && a.mass == b.mass; }
  friend bool operator!=(TaskMass a, TaskMass b) { return !(a == b); }
};

/// Sparse vector over tasks, ascending by task, masses > 0. Room for the null task and two others
/// without an allocation: large clusterings hold one for each primitive.
using SparseMasses = boost::container::small_vector<TaskMass, 3>;

/// H(p) = -sum p log2 p in bits of a sparse distribution (masses sum to 1).
double computeEntropyBits(const SparseMasses& distribution);

/// Sum of two sparse vectors. O(support).
SparseMasses addMasses(const SparseMasses& a, const SparseMasses& b);

/// `masses` scaled to sum 1; empty stays empty.
SparseMasses toDistribution(const SparseMasses& masses);

/// h(a, b) = a log2(1 + b/a) + b log2(1 + a/b) >= 0 in bits: the entropy that mixing masses a and b
/// adds, to full relative precision also for a << b. 0 if either is 0.
double computeMixingBits(double a, double b);

/// D = (n_a + n_b) JS(p(y|a), p(y|b)) [Clio24, Eq. 2 times N], in bits times primitives, unrounded.
///
/// With h as above, D = h(n_a, n_b) - sum_y h(m_a(y), m_b(y)): only the tasks that both serve
/// enter, and clusters that share none cost h(n_a, n_b) whatever they serve. Exactly 0 for equal
/// distributions (what lies under the arithmetic's resolution counts as equal). O(support).
double computeMergeCost(const SparseMasses& a, double count_a, const SparseMasses& b,
                        double count_b);

/// Costs are compared as whole multiples of 1e-9, so that ties do not hang on rounding.
constexpr double kCostUnit = 1e-9;

/// D rounded to 9 decimals, as a count of kCostUnit. Ordering and thresholds use this number.
std::int64_t roundCost(double cost);

}  // namespace tsg::bottleneck

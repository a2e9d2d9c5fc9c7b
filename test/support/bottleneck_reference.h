// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "task_scene_graph/bottleneck/clustering.h"

/// Agglomerative IB written down straight from the equations, slow on purpose: dense matrices,
/// every quantity computed anew at every merge, no code shared with the module.
namespace tsg::test {

struct ReferencePrimitive {
  Embedding embedding;
  Aabb box;
};

/// A whole problem; ordered by key.
struct ReferenceScene {
  std::map<bottleneck::NodeKey, ReferencePrimitive> primitives;
  EmbeddingMatrix tasks;
};

using KeyPair = std::pair<bottleneck::NodeKey, bottleneck::NodeKey>;

/// All pairs of primitives whose boxes overlap strictly.
std::vector<KeyPair> findOverlaps(const ReferenceScene& scene);

/// p(y|x), (M+1) x N, columns by ascending key, row 0 the null task.
Eigen::MatrixXd computeDenseRelevance(const ReferenceScene& scene,
                                      const bottleneck::ClusteringConfig& config);

/// sum_x p(x) sum_y p(y|x) log2(p(y|x) / p(y)) in bits.
double computeDenseInformation(const Eigen::VectorXd& p_x, const Eigen::MatrixXd& p_y_given_x,
                               const Eigen::VectorXd& p_y);

/// H(sum_i w_i p_i) - sum_i w_i H(p_i) in bits over the columns, w summing to 1.
double computeDenseJensenShannon(const Eigen::MatrixXd& columns, const Eigen::VectorXd& weights);
double computeDenseEntropy(const Eigen::VectorXd& p);

struct ReferenceResult {
  double information = 0.0;
  std::vector<bottleneck::Merge> merges;                   ///< accepted, in order
  std::vector<std::vector<bottleneck::NodeKey>> clusters;  ///< ascending by smallest key
  std::vector<double> losses;                              ///< I before - I after of each merge
};

/// O(N^3 M).
ReferenceResult clusterDense(const ReferenceScene& scene, const std::vector<KeyPair>& edges,
                             const bottleneck::ClusteringConfig& config);

/// What random scenes look like.
struct SceneOptions {
  int num_primitives = 30;
  int num_tasks = 5;
  int dimension = 12;
  double mean_degree = 4.0;
  double duplicate_share = 0.2;   ///< have the embedding of an earlier one
  double irrelevant_share = 0.2;  ///< serve no task
};

/// Random primitives around random tasks.
class SceneGenerator {
 public:
  SceneGenerator(const SceneOptions& options, std::uint32_t seed);
  ReferenceScene makeScene();
  ReferencePrimitive makePrimitive();
  const EmbeddingMatrix& tasks() const { return tasks_; }
  EmbeddingMatrix makeTasks();
  int uniformInt(int min, int max);  ///< inclusive
  double uniform(double min, double max);

 private:
  Embedding makeEmbedding();
  Aabb makeBox();
  Embedding makeNoise();

  SceneOptions options_;
  std::mt19937 random_;
  EmbeddingMatrix tasks_;
  std::vector<Embedding> earlier_;
};

}  // namespace tsg::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/embedding.h"

namespace tsg::test {

/// Agglomerative IB done the way the published implementation does it, as a yardstick for speed:
/// all pairs of boxes compared, dense p(y|x), and per merge a scan of all edges for the smallest, a
/// sweep over all edges and assignments, and the mutual information computed anew from copies of
/// whole matrices. Its N x N matrix p(z|x), which no result depends on, is left out of maps of more
/// than 5,000. Returns the number of merges, to the end. O(N^2 + merges (E + N M)).
std::size_t clusterByRescanning(const std::vector<Embedding>& embeddings,
                                const std::vector<Aabb>& boxes, const EmbeddingMatrix& tasks,
                                double alpha);

}  // namespace tsg::test

// SPDX-License-Identifier: BSD-3-Clause
#include "region_groups.h"

#include <algorithm>
#include <set>
#include <tuple>

namespace tsg::scene_graph {
namespace {

/// Groups of places and how much each is joined to its neighbours.
class GroupGraph {
 public:
  GroupGraph(PlaceGroups groups, const std::vector<PlaceEdge>& edges)
      : groups_(std::move(groups)), joints_m_(groups_.size()) {
    std::unordered_map<PlaceId, std::size_t> group_of;
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      for (const PlaceId place : groups_[i]) group_of[place] = i;
    }
    for (const PlaceEdge& edge : edges) {
      const auto a = group_of.find(edge.a);
      const auto b = group_of.find(edge.b);
      if (a == group_of.end() || b == group_of.end() || a->second == b->second) continue;
      joints_m_[a->second][b->second] += edge.clearance_m;
      joints_m_[b->second][a->second] += edge.clearance_m;
    }
  }

  const PlaceGroups& groups() const { return groups_; }
  std::size_t size(std::size_t group) const { return groups_[group].size(); }
  PlaceId firstPlace(std::size_t group) const {
    return *std::min_element(groups_[group].begin(), groups_[group].end());
  }
  bool hasNeighbour(std::size_t group) const { return !joints_m_[group].empty(); }

  /// Precondition: hasNeighbour(group).
  std::size_t findStrongest(std::size_t group) const {
    const auto isWeaker = [&](const auto& left, const auto& right) {
      if (left.second != right.second) return left.second < right.second;
      return firstPlace(right.first) < firstPlace(left.first);
    };
    return std::max_element(joints_m_[group].begin(), joints_m_[group].end(), isWeaker)->first;
  }

  void join(std::size_t from, std::size_t to) {
    groups_[to].insert(groups_[to].end(), groups_[from].begin(), groups_[from].end());
    groups_[from].clear();
    for (const auto& [other, joint_m] : joints_m_[from]) {
      joints_m_[other].erase(from);
      if (other == to) continue;
      joints_m_[to][other] += joint_m;
      joints_m_[other][to] += joint_m;
    }
    joints_m_[from].clear();
  }

 private:
  PlaceGroups groups_;
  std::vector<std::map<std::size_t, double>> joints_m_;
};

PlaceGroups tidy(PlaceGroups groups) {
  groups.erase(std::remove_if(groups.begin(), groups.end(),
                              [](const std::vector<PlaceId>& group) { return group.empty(); }),
               groups.end());
  for (auto& group : groups) std::sort(group.begin(), group.end());
  std::sort(groups.begin(), groups.end());
  return groups;
}

}  // namespace

PlaceGroups absorbSmallGroups(PlaceGroups groups, const std::vector<PlaceEdge>& edges,
                              std::size_t min_places) {
  const auto isSmall = [&](const auto& group) { return group.size() < min_places; };
  if (std::none_of(groups.begin(), groups.end(), isSmall)) return tidy(std::move(groups));
  GroupGraph graph(std::move(groups), edges);
  std::set<std::tuple<std::size_t, PlaceId, std::size_t>> small;
  const auto makeKey = [&](std::size_t group) {
    return std::make_tuple(graph.size(group), graph.firstPlace(group), group);
  };
  for (std::size_t i = 0; i < graph.groups().size(); ++i) {
    if (isSmall(graph.groups()[i])) small.insert(makeKey(i));
  }
  while (!small.empty()) {
    const std::size_t group = std::get<2>(*small.begin());
    small.erase(small.begin());
    if (!graph.hasNeighbour(group)) continue;
    const std::size_t target = graph.findStrongest(group);
    small.erase(makeKey(target));
    graph.join(group, target);
    if (isSmall(graph.groups()[target])) small.insert(makeKey(target));
  }
  return tidy(graph.groups());
}

void RegionIds::adopt(const std::map<RegionId, std::vector<PlaceId>>& places_of) {
  region_of_.clear();
  for (const auto& [id, places] : places_of) {
    next_ = std::max(next_, id.value + 1);
    for (const PlaceId place : places) region_of_[place] = id;
  }
}

std::vector<RegionId> RegionIds::match(const PlaceGroups& groups) {
  std::vector<std::tuple<std::size_t, RegionId, std::size_t>> shares;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    std::map<RegionId, std::size_t> shared;
    for (const PlaceId place : groups[i]) {
      const auto found = region_of_.find(place);
      if (found != region_of_.end()) ++shared[found->second];
    }
    for (const auto& [id, count] : shared) shares.emplace_back(count, id, i);
  }
  std::sort(shares.begin(), shares.end(), [](const auto& left, const auto& right) {
    if (std::get<0>(left) != std::get<0>(right)) return std::get<0>(left) > std::get<0>(right);
    return std::tie(std::get<1>(left), std::get<2>(left)) <
           std::tie(std::get<1>(right), std::get<2>(right));
  });
  std::vector<RegionId> ids(groups.size());
  std::set<RegionId> taken;
  for (const auto& [count, id, group] : shares) {
    if (!ids[group].isValid() && taken.insert(id).second) ids[group] = id;
  }
  region_of_.clear();
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (!ids[i].isValid()) ids[i] = RegionId{next_++};
    for (const PlaceId place : groups[i]) region_of_[place] = ids[i];
  }
  return ids;
}

}  // namespace tsg::scene_graph

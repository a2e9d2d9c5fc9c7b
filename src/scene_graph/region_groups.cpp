// SPDX-License-Identifier: BSD-3-Clause
#include "region_groups.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace tsg::scene_graph {
namespace {

/// Groups of places and how much the small ones are joined to their neighbours.
class GroupGraph {
 public:
  GroupGraph(PlaceGroups groups, const std::vector<PlaceEdge>& edges, std::size_t min_places)
      : groups_(std::move(groups)), joints_m_(groups_.size()) {
    std::vector<const PlaceEdge*> joints;
    const auto group_of = findGroups(edges, min_places, joints);
    for (const PlaceEdge* edge : joints) {
      const std::size_t a = group_of.at(edge->a);
      const std::size_t b = group_of.at(edge->b);
      if (a == kNoGroup || b == kNoGroup || a == b) continue;
      joints_m_[a][b] += edge->clearance_m;
      joints_m_[b][a] += edge->clearance_m;
    }
  }

  const PlaceGroups& groups() const { return groups_; }
  std::size_t size(std::size_t group) const { return groups_[group].size(); }
  PlaceId firstPlace(std::size_t group) const {
    return *std::min_element(groups_[group].begin(), groups_[group].end());
  }
  /// Precondition: the group was small, or one that was has joined it.
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
  static constexpr std::size_t kNoGroup = static_cast<std::size_t>(-1);

  /// The groups of the places at edges of small groups, and these edges: few, so that most places
  /// are never looked up in a large table.
  std::unordered_map<PlaceId, std::size_t> findGroups(const std::vector<PlaceEdge>& edges,
                                                      std::size_t min_places,
                                                      std::vector<const PlaceEdge*>& joints) const {
    std::unordered_map<PlaceId, std::size_t> group_of;
    for (const auto& group : groups_) {
      if (group.size() >= min_places) continue;
      for (const PlaceId place : group) group_of[place] = kNoGroup;
    }
    for (const PlaceEdge& edge : edges) {
      if (group_of.count(edge.a) + group_of.count(edge.b) > 0) joints.push_back(&edge);
    }
    for (const PlaceEdge* edge : joints) {
      group_of.emplace(edge->a, kNoGroup);
      group_of.emplace(edge->b, kNoGroup);
    }
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      for (const PlaceId place : groups_[i]) {
        const auto found = group_of.find(place);
        if (found != group_of.end()) found->second = i;
      }
    }
    return group_of;
  }

  PlaceGroups groups_;
  std::vector<std::map<std::size_t, double>> joints_m_;
};

std::uint64_t hashPlaces(const std::vector<PlaceId>& places) {
  SetHash hash;
  for (const PlaceId place : places) hash.add(place.value);
  return hash.value();
}

/// What one large group gave is in order already.
template <typename Pairs>
void sortIfNeeded(Pairs& pairs) {
  if (!std::is_sorted(pairs.begin(), pairs.end())) std::sort(pairs.begin(), pairs.end());
}

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
  GroupGraph graph(std::move(groups), edges, min_places);
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
  groups_.clear();
  ids_.clear();
  names_ = SetNames{kMaxNames};
  for (const auto& [id, places] : places_of) {
    next_ = std::max(next_, id.value + 1);
    groups_.push_back(places);
    std::sort(groups_.back().begin(), groups_.back().end());
    ids_.push_back(id);
    names_.remember(hashPlaces(places), id.value);
  }
}

std::vector<RegionIds::Share> RegionIds::findShares(const PlaceGroups& groups,
                                                    const PlaceRegions& region_of) {
  std::vector<std::pair<PlaceId, std::size_t>> group_of;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    for (const PlaceId place : groups[i]) group_of.emplace_back(place, i);
  }
  sortIfNeeded(group_of);
  std::vector<std::map<RegionId, std::size_t>> shared(groups.size());
  auto former = region_of.begin();
  for (const auto& [place, group] : group_of) {
    while (former != region_of.end() && former->first < place) ++former;
    if (former == region_of.end()) break;
    if (former->first == place) ++shared[group][former->second];
  }
  std::vector<Share> shares;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    for (const auto& [id, count] : shared[i]) shares.push_back({count, id, i});
  }
  std::sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
    if (a.count != b.count) return a.count > b.count;
    return std::tie(a.id, a.group) < std::tie(b.id, b.group);
  });
  return shares;
}

void RegionIds::claimKnown(const std::vector<Share>& shares, const std::vector<RegionId>& known,
                           std::vector<RegionId>& ids) {
  std::set<RegionId> seen;
  std::set<RegionId> bound(ids.begin(), ids.end());  // and those that go to groups without another
  for (const Share& share : shares) {
    if (seen.insert(share.id).second && !known[share.group].isValid()) bound.insert(share.id);
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (known[i].isValid() && bound.insert(known[i]).second) ids[i] = known[i];
  }
}

std::vector<RegionId> RegionIds::match(const PlaceGroups& groups) {
  std::vector<RegionId> ids(groups.size());
  const auto region_of = matchUnchanged(groups, ids);
  std::vector<std::uint64_t> sets(groups.size());
  std::vector<RegionId> known(groups.size());
  PlaceGroups changed(groups.size());  // empty where nothing is to do
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (ids[i].isValid()) continue;
    changed[i] = groups[i];
    sets[i] = hashPlaces(groups[i]);
    known[i] = RegionId{names_.find(sets[i])};
  }
  const std::vector<Share> shares = findShares(changed, region_of);
  claimKnown(shares, known, ids);
  std::set<RegionId> taken(ids.begin(), ids.end());
  for (const Share& share : shares) {
    RegionId& id = ids[share.group];
    if (!id.isValid() && taken.insert(share.id).second) id = share.id;
  }
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (!ids[i].isValid()) ids[i] = RegionId{next_++};
    if (!changed[i].empty()) names_.remember(sets[i], ids[i].value);
  }
  groups_ = groups;
  ids_ = ids;
  return ids;
}

/// Sets the ids of groups that were there before. No other group has one of their places, so no
/// other can ask for their ids. @returns the regions of the other places, ascending
RegionIds::PlaceRegions RegionIds::matchUnchanged(const PlaceGroups& groups,
                                                  std::vector<RegionId>& ids) const {
  std::unordered_map<PlaceId, std::size_t> group_of;  // by its first place
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (!groups[i].empty()) group_of[groups[i].front()] = i;
  }
  PlaceRegions region_of;
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const auto found = groups_[k].empty() ? group_of.end() : group_of.find(groups_[k].front());
    if (found != group_of.end() && groups[found->second] == groups_[k]) {
      ids[found->second] = ids_[k];
    } else {
      for (const PlaceId place : groups_[k]) region_of.emplace_back(place, ids_[k]);
    }
  }
  sortIfNeeded(region_of);
  return region_of;
}

}  // namespace tsg::scene_graph

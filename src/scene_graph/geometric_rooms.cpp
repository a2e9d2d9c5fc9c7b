// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/geometric_rooms.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <tuple>

#include "task_scene_graph/core/find_by_id.h"
#include "union_find.h"

namespace tsg::scene_graph {
namespace {

constexpr std::size_t kNoRoom = static_cast<std::size_t>(-1);

/// An edge by the indices of its places.
struct Passage {
  std::size_t a = 0;
  std::size_t b = 0;
  double clearance_m = 0.0;
};

std::size_t findIndex(const PlaceGraph& graph, PlaceId id) {
  const auto found = findById(graph.places, id, [](const Place& place) { return place.id; });
  return static_cast<std::size_t>(found - graph.places.begin());
}

std::vector<Passage> listPassages(const PlaceGraph& graph) {
  std::vector<Passage> passages;
  passages.reserve(graph.edges.size());
  for (const PlaceEdge& edge : graph.edges) {
    passages.push_back({findIndex(graph, edge.a), findIndex(graph, edge.b), edge.clearance_m});
  }
  return passages;
}

/// Connected sets of places with their sizes, and how many are large.
class Components {
 public:
  Components(std::size_t num_places, std::size_t min_size)
      : sets_(num_places),
        sizes_(num_places, 1),
        min_size_(min_size),
        num_large_(min_size <= 1 ? num_places : 0) {}

  void join(std::size_t a, std::size_t b) {
    a = sets_.find(a);
    b = sets_.find(b);
    if (a == b) return;
    if (sizes_[a] < sizes_[b]) std::swap(a, b);
    num_large_ -= isLarge(a) + isLarge(b);
    sets_.attach(b, a);
    sizes_[a] += sizes_[b];
    num_large_ += isLarge(a);
  }
  std::size_t find(std::size_t place) { return sets_.find(place); }
  std::size_t isLarge(std::size_t root) const { return sizes_[root] >= min_size_ ? 1 : 0; }
  std::size_t numLarge() const { return num_large_; }

 private:
  UnionFind sets_;
  std::vector<std::size_t> sizes_;
  std::size_t min_size_;
  std::size_t num_large_;
};

/// First entries of the runs of equal counts, and behind the last run the end.
std::vector<std::size_t> findRuns(const std::vector<FiltrationStep>& window) {
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (i == 0 || window[i].num_components != window[i - 1].num_components) starts.push_back(i);
  }
  starts.push_back(window.size());
  return starts;
}

double computeLifetime(const std::vector<FiltrationStep>& window, std::size_t start,
                       std::size_t end) {
  return window[end - 1].dilation_m - window[start].dilation_m;
}

std::optional<double> chooseDilation(const PlaceGraph& graph, const GeometricRoomsConfig& config) {
  const auto window =
      cutToWindow(computeFiltration(graph, static_cast<std::size_t>(config.min_component_size),
                                    config.dilation_step_m),
                  config.min_dilation_m, config.max_dilation_m);
  const bool is_relative = config.dilation_choice == DilationChoice::kPlateau;
  const double min_lifetime_m = is_relative
                                    ? config.min_lifetime_ratio * computeLongestLifetime(window)
                                    : config.min_lifetime_m;
  const auto chosen = choosePlateau(window, min_lifetime_m);
  return chosen ? std::optional<double>(chosen->dilation_m) : std::nullopt;
}

/// Room of each place: the smallest place of its component, kNoRoom outside of seeds.
std::vector<std::size_t> findSeeds(const PlaceGraph& graph, const std::vector<Passage>& passages,
                                   double dilation_m, int min_size) {
  const auto isOpen = [&](std::size_t i) { return graph.places[i].clearance_m > dilation_m; };
  Components components(graph.places.size(), static_cast<std::size_t>(min_size));
  for (const Passage& passage : passages) {
    if (passage.clearance_m <= dilation_m || !isOpen(passage.a) || !isOpen(passage.b)) continue;
    components.join(passage.a, passage.b);
  }
  std::vector<std::size_t> rooms(graph.places.size(), kNoRoom);
  std::vector<std::size_t> smallest(graph.places.size(), kNoRoom);  // by root
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const std::size_t root = components.find(i);
    if (smallest[root] == kNoRoom) smallest[root] = i;
    if (isOpen(i) && components.isLarge(root) != 0) rooms[i] = smallest[root];
  }
  return rooms;
}

/// Places next to rooms join them, the widest passage first.
void growSeeds(const std::vector<Passage>& passages, std::vector<std::size_t>& rooms) {
  std::vector<std::vector<std::pair<double, std::size_t>>> neighbours(rooms.size());
  for (const Passage& passage : passages) {
    neighbours[passage.a].emplace_back(passage.clearance_m, passage.b);
    neighbours[passage.b].emplace_back(passage.clearance_m, passage.a);
  }
  // (clearance, smaller place first, smaller room first)
  using Step = std::tuple<double, std::size_t, std::size_t>;
  const auto isLater = [](const Step& left, const Step& right) {
    const auto key = [](const Step& step) {
      return std::make_tuple(-std::get<0>(step), std::get<1>(step), std::get<2>(step));
    };
    return key(left) > key(right);
  };
  std::priority_queue<Step, std::vector<Step>, decltype(isLater)> steps(isLater);
  const auto pushNeighbours = [&](std::size_t place) {
    for (const auto& [clearance_m, next] : neighbours[place]) {
      if (rooms[next] == kNoRoom) steps.emplace(clearance_m, next, rooms[place]);
    }
  };
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    if (rooms[i] != kNoRoom) pushNeighbours(i);
  }
  while (!steps.empty()) {
    const auto [clearance_m, place, room] = steps.top();
    steps.pop();
    if (rooms[place] != kNoRoom) continue;
    rooms[place] = room;
    pushNeighbours(place);
  }
}

}  // namespace

std::vector<FiltrationStep> computeFiltration(const PlaceGraph& graph,
                                              std::size_t min_component_size,
                                              double dilation_step_m) {
  std::vector<Passage> passages = listPassages(graph);
  std::sort(passages.begin(), passages.end(), [](const Passage& left, const Passage& right) {
    return std::make_tuple(-left.clearance_m, left.a, left.b) <
           std::make_tuple(-right.clearance_m, right.a, right.b);
  });
  Components components(graph.places.size(), min_component_size);
  std::vector<FiltrationStep> filtration;
  for (const Passage& passage : passages) {
    components.join(passage.a, passage.b);
    const bool is_new = filtration.empty() || std::abs(filtration.back().dilation_m -
                                                       passage.clearance_m) >= dilation_step_m;
    if (is_new) filtration.push_back({passage.clearance_m, 0});
    filtration.back().num_components = components.numLarge();
  }
  std::reverse(filtration.begin(), filtration.end());
  return filtration;
}

std::vector<FiltrationStep> cutToWindow(const std::vector<FiltrationStep>& filtration,
                                        double min_dilation_m, double max_dilation_m) {
  const auto countBelow = [&](double dilation_m) {
    return std::count_if(filtration.begin(), filtration.end(),
                         [&](const FiltrationStep& step) { return step.dilation_m < dilation_m; });
  };
  const auto start = countBelow(min_dilation_m);
  const auto below_max = countBelow(max_dilation_m);
  const auto end = below_max == 0 ? static_cast<std::ptrdiff_t>(filtration.size()) : below_max - 1;
  if (start >= end) return {};
  return {filtration.begin() + start, filtration.begin() + end};
}

double computeLongestLifetime(const std::vector<FiltrationStep>& window) {
  const auto runs = findRuns(window);
  double longest_m = 0.0;
  for (std::size_t k = 0; k + 1 < runs.size(); ++k) {
    longest_m = std::max(longest_m, computeLifetime(window, runs[k], runs[k + 1]));
  }
  return longest_m;
}

std::optional<FiltrationStep> choosePlateau(const std::vector<FiltrationStep>& window,
                                            double min_lifetime_m) {
  if (window.empty()) return std::nullopt;
  const auto runs = findRuns(window);
  FiltrationStep best = window.front();
  std::size_t most = 0;
  for (std::size_t k = 0; k + 1 < runs.size(); ++k) {
    const FiltrationStep& first = window[runs[k]];
    const bool is_long = computeLifetime(window, runs[k], runs[k + 1]) >= min_lifetime_m;
    if (!is_long || first.num_components <= most) continue;
    best = first;
    most = first.num_components;
  }
  return best;
}

std::vector<std::vector<PlaceId>> computeGeometricRooms(const PlaceGraph& graph,
                                                        const GeometricRoomsConfig& config) {
  const auto dilation_m = chooseDilation(graph, config);
  if (!dilation_m) return {};
  const std::vector<Passage> passages = listPassages(graph);
  auto rooms = findSeeds(graph, passages, *dilation_m, config.min_component_size);
  growSeeds(passages, rooms);
  std::map<std::size_t, std::vector<PlaceId>> places_of;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    if (rooms[i] != kNoRoom) places_of[rooms[i]].push_back(graph.places[i].id);
  }
  std::vector<std::vector<PlaceId>> found;
  for (auto& [room, members] : places_of) {
    if (members.size() < static_cast<std::size_t>(config.min_room_size)) continue;
    found.push_back(std::move(members));
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace tsg::scene_graph

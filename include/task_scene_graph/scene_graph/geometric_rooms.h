// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/primitives.h"

/// Rooms from the shape of free space alone [Hydra22, Sec. IV-C]: places that stay together when
/// all obstacles are dilated until doors are closed.
namespace tsg::scene_graph {

/// How the dilation is chosen from the number of components it leaves.
enum class DilationChoice {
  kPlateau,          ///< most components among the long runs, long by a share of the longest
  kPlateauThreshold  ///< the same, long by min_lifetime_m
};

/// The defaults are those of Hydra's dataset configurations.
struct GeometricRoomsConfig {
  double min_dilation_m = 0.5;
  double max_dilation_m = 1.2;
  DilationChoice dilation_choice = DilationChoice::kPlateau;
  double min_lifetime_ratio = 0.25;
  double min_lifetime_m = 0.1;
  double dilation_step_m = -1.0;
  int min_component_size = 10;
  int min_room_size = 10;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("min_dilation_m", self.min_dilation_m, {0.0, 10.0}, "m",
            "least growth of obstacles that is tried");
    v.field("max_dilation_m", self.max_dilation_m, {0.0, 10.0}, "m",
            "largest growth of obstacles that is tried");
    v.choice("dilation_choice", self.dilation_choice,
             {{"plateau", DilationChoice::kPlateau},
              {"plateau_threshold", DilationChoice::kPlateauThreshold}},
             "growths over which the number of parts stays the same count if they are longer than "
             "min_lifetime_ratio of the longest, or than min_lifetime_m");
    v.field("min_lifetime_ratio", self.min_lifetime_ratio, {0.0, 1.0}, "",
            "see dilation_choice: plateau");
    v.field("min_lifetime_m", self.min_lifetime_m, {0.0, 10.0}, "m",
            "see dilation_choice: plateau_threshold");
    v.field("dilation_step_m", self.dilation_step_m, {-1.0, 10.0}, "m",
            "edges whose clearances differ by less are one step; -1: each edge is one");
    v.field("min_component_size", self.min_component_size, {1, 1000}, "",
            "parts of fewer places are no seeds of rooms");
    v.field("min_room_size", self.min_room_size, {1, 1000}, "",
            "rooms of fewer places are dropped");
  }
};

/// What remains of the place graph when obstacles grow.
struct FiltrationStep {
  double dilation_m = 0.0;
  std::size_t num_components = 0;  ///< of at least the minimum size
};

/// The number of components at each growth: edges by falling clearance (equal: by ids), after each
/// the number of connected sets of at least `min_component_size` places; ascending by dilation. An
/// edge whose clearance differs from the last entry's by less than `dilation_step_m` replaces its
/// count. O(E log E).
std::vector<FiltrationStep> computeFiltration(const PlaceGraph& graph,
                                              std::size_t min_component_size,
                                              double dilation_step_m);

/// The entries that may be chosen: from the first after the last one below `min_dilation_m` to the
/// last one below `max_dilation_m`, exclusive; to the end if none is below.
std::vector<FiltrationStep> cutToWindow(const std::vector<FiltrationStep>& filtration,
                                        double min_dilation_m, double max_dilation_m);

/// The first entry of the run of equal counts that has most components among those that last at
/// least `min_lifetime_m` (last minus first dilation); of equal ones the smallest dilation. If no
/// run with components is long enough: the first entry of all. Nothing for an empty list.
std::optional<FiltrationStep> choosePlateau(const std::vector<FiltrationStep>& window,
                                            double min_lifetime_m);

/// The longest run of equal counts, last minus first dilation; 0 for an empty list.
double computeLongestLifetime(const std::vector<FiltrationStep>& window);

/// Rooms as sets of places, each ascending; the sets by their smallest place. Places that no edge
/// joins to a room are in none. Seeds are the components, of at least `min_component_size` places,
/// of places and edges with clearances above the chosen dilation; the other places go to the
/// neighbouring seed with the widest edge, one by one, widest first (equal: smaller place id).
/// Ties and the order of rooms do not depend on the order of edges. O((V + E) log E).
/// deviation: Hydra orders rooms by when their places were last updated. Its other ways to choose
/// the dilation and to spread the rest, which none of its configurations uses, are left out.
std::vector<std::vector<PlaceId>> computeGeometricRooms(const PlaceGraph& graph,
                                                        const GeometricRoomsConfig& config);

}  // namespace tsg::scene_graph

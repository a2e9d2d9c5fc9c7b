// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {

/// Puts models into an apartment so that no two share volume, doorways stay free and fronts that
/// need space keep it. Every place is found by seeded trial; a thing that finds none is left out.
class Furnisher {
 public:
  explicit Furnisher(Apartment& apartment);

  /// Backs against the wall, anywhere along it. Returns the index of the first new instance, or -1.
  int placeAlongWall(const Room& room, const Arrangement& things, Side side, Random& random);
  /// The first side on which there is a place, from a random one on.
  int placeAlongAnyWall(const Room& room, const Arrangement& things, Random& random);
  /// Away from the walls, in any quarter turn.
  int placeInMiddle(const Room& room, const Arrangement& things, Random& random);
  /// At a fixed pose if it is free there.
  int placeAt(const Room& room, const Arrangement& things, const Pose& T_world_group);
  /// On a surface of an instance with this phrase in this room, turned a little.
  bool placeOn(const Room& room, const std::string& support_phrase, const Model& thing,
               double max_turn_rad, Random& random);
  /// Likewise with things that touch each other: all of them or none. They become a group.
  bool placeGroupOn(const Room& room, const std::string& support_phrase, const std::string& phrase,
                    const Arrangement& things, double max_turn_rad, Random& random);
  /// On the floor with its back to a wall, anywhere.
  bool placeGroupAlongAnyWall(const Room& room, const std::string& phrase,
                              const Arrangement& things, Random& random);

 private:
  struct Surface {
    int room = 0;
    std::string phrase;
    Pose T_world_model = Pose::Identity();
    Support support;
  };

  bool isFree(const Room& room, const Arrangement& things, const Pose& T_world_group) const;
  bool isFreeOn(const Aabb& box, const Rect& area_m) const;
  int add(const Room& room, const Model& model, const Pose& T_world_model);
  void addSolids(const Model& model, const Pose& T_world_model, Instance& instance);
  bool placeAllOn(const Room& room, const std::string& support_phrase, const Arrangement& things,
                  double max_turn_rad, Random& random);
  /// Of the newest `count` instances.
  void addGroup(const std::string& phrase, std::size_t count);

  Apartment& apartment_;
  std::vector<Aabb> keepouts_;
  std::vector<Surface> surfaces_;
};

inline Arrangement alone(const Model& model) { return {{model, Pose::Identity()}}; }

/// Fills a room of an apartment according to its kind.
void furnishRoom(Furnisher& furnisher, const Room& room, Random& random);
/// Windows, and a lamp under the ceiling.
void addWindows(Furnisher& furnisher, const Room& room, int count, Random& random);
void addCeilingLamp(Furnisher& furnisher, const Room& room);
/// Fills all rooms of an apartment.
void furnishRooms(Apartment& apartment, Random& random);
/// Fills all rooms of a world of work, with groups of things that touch on its tables.
void furnishWorkRooms(Apartment& apartment, Random& random);

}  // namespace tsg::simulation

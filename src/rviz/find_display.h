// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rviz/display.h>
#include <rviz/display_group.h>
#include <rviz/properties/property.h>

#include <string>

namespace tsg::rviz_plugin {

/// The first display of a group that shows the markers of a topic; null if none does.
inline rviz::Display* findMarkerDisplay(const rviz::DisplayGroup& displays,
                                        const std::string& topic) {
  for (int i = 0; i < displays.numDisplays(); ++i) {
    rviz::Display* display = displays.getDisplayAt(i);
    if (display->getClassId() != "rviz/MarkerArray") continue;
    if (display->subProp("Marker Topic")->getValue().toString().toStdString() == topic) {
      return display;
    }
  }
  return nullptr;
}

}  // namespace tsg::rviz_plugin

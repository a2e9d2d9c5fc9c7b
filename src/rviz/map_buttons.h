// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <QWidget>

#include "chain_link.h"

class QPushButton;

namespace tsg::rviz_plugin {

/// What keeps, brings back and empties the map: buttons to save, load, pause, resume and reset.
/// Load and Reset ask first.
class MapButtons : public QWidget {
 public:
  explicit MapButtons(ChainLink& link, QWidget* parent = nullptr);

 private:
  QPushButton* addButton(const char* text, const char* service, const char* tip);
  void askForMap();
  void askForReset();

  ChainLink& link_;
  QString folder_;  ///< as last typed
};

}  // namespace tsg::rviz_plugin

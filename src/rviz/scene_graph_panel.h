// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rviz/panel.h>

#include <memory>
#include <string>

#include "chain_link.h"
#include "question_tab.h"
#include "stage_tab.h"
#include "task_tab.h"
#include "view_fitter.h"

class QLabel;
class QLineEdit;
class QPushButton;
class QTabWidget;

namespace rviz {
class Display;
}  // namespace rviz

namespace tsg::rviz_plugin {

/// The panel of a running chain in rviz: its tasks, questions to its map, its stages, and what
/// starts and ends. Nothing it does waits for ROS (ChainLink). What is selected in the view is
/// explained, and the view can be fitted to the map.
class SceneGraphPanel : public rviz::Panel {
  Q_OBJECT
 public:
  explicit SceneGraphPanel(QWidget* parent = nullptr);
  ~SceneGraphPanel() override;

  void onInitialize() override;
  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private Q_SLOTS:
  void onSelectionChanged();

 private:
  ChainLink::Handlers makeHandlers();
  QWidget* makeChainRow();
  void showScores(bool are_shown);
  void follow(const QString& chain);
  void lookAt(const std::string& frame, const geometry_msgs::Point& point);
  void say(const std::string& text, bool is_error);

  QLineEdit* chain_;
  QPushButton* fit_;
  bool is_fitting_ = false;  ///< as configured, before rviz is there
  ViewFitter* fitter_ = nullptr;
  QLabel* note_;
  QTabWidget* tabs_;
  TaskTab* tasks_;
  QuestionTab* questions_;
  StageTab* stages_;
  std::string selected_;
  std::unique_ptr<ChainLink> link_;  ///< last: its handlers use the rest
};

}  // namespace tsg::rviz_plugin

// SPDX-License-Identifier: BSD-3-Clause
#include "scene_graph_panel.h"

#include <rviz/frame_manager.h>
#include <rviz/properties/property.h>
#include <rviz/properties/property_tree_model.h>
#include <rviz/selection/selection_manager.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/visualization_manager.h>

#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QRegularExpression>
#include <QTabWidget>
#include <QVBoxLayout>
#include <map>
#include <pluginlib/class_list_macros.hpp>

#include "find_display.h"
#include "map_buttons.h"

namespace tsg::rviz_plugin {
namespace {

constexpr const char* kDefaultChain = "/task_scene_graph";

/// A thing of the graph that a marker's name tells of.
struct Selected {
  std::uint8_t what = 0;
  std::uint64_t id = 0;
  std::string name;
};

/// "Marker object_boxes/12", "Marker question_primitives/7" and "Marker regions/3"; id 0 for
/// others.
Selected readMarkerName(const QString& name) {
  static const QRegularExpression pattern(
      "^Marker (?:question_)?(object|primitive|region)\\w*/(\\d+)$");
  static const std::map<QString, std::uint8_t> kinds = {
      {"object", msg::ExplainRequest::OBJECT},
      {"primitive", msg::ExplainRequest::PRIMITIVE},
      {"region", msg::ExplainRequest::REGION}};
  const QRegularExpressionMatch match = pattern.match(name);
  if (!match.hasMatch() || name.contains("edges")) return {};
  return {kinds.at(match.captured(1)), match.captured(2).toULongLong(),
          (match.captured(1) + " " + match.captured(2)).toStdString()};
}

}  // namespace

SceneGraphPanel::SceneGraphPanel(QWidget* parent) : rviz::Panel(parent) {
  link_ = std::make_unique<ChainLink>(makeHandlers());
  tasks_ = new TaskTab(*link_);
  questions_ = new QuestionTab(
      *link_,
      [this](const std::string& frame, const geometry_msgs::Point& point) { lookAt(frame, point); },
      [this](bool are_shown) { showScores(are_shown); });
  stages_ = new StageTab;
  tabs_ = new QTabWidget;
  tabs_->setObjectName("tabs");
  tabs_->addTab(tasks_, "Tasks");
  tabs_->addTab(questions_, "Ask");
  tabs_->addTab(stages_, "Stages");
  note_ = new QLabel;
  note_->setObjectName("note");
  note_->setWordWrap(true);
  note_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(makeChainRow());
  layout->addWidget(tabs_, 1);
  layout->addWidget(new MapButtons(*link_));
  layout->addWidget(note_);
}

SceneGraphPanel::~SceneGraphPanel() {
  chain_->blockSignals(true);  // a field that loses the focus as it goes would use the link
}

ChainLink::Handlers SceneGraphPanel::makeHandlers() {
  ChainLink::Handlers handlers;
  handlers.on_tasks = [this](const auto& tasks) { tasks_->setTasks(tasks); };
  handlers.on_settings = [this](const auto& settings) { tasks_->setSettings(settings); };
  handlers.on_diagnostics = [this](const auto& message) { stages_->add(message); };
  handlers.on_answers = [this](const auto& answers) { questions_->setAnswers(answers); };
  handlers.on_explanation = [this](const auto& text) { questions_->setExplanation(text); };
  handlers.on_picture = [this](const auto& picture) { questions_->setPicture(picture); };
  handlers.on_note = [this](const auto& text) { say(text, false); };
  handlers.on_error = [this](const auto& text) { say(text, true); };
  return handlers;
}

QWidget* SceneGraphPanel::makeChainRow() {
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  chain_ = new QLineEdit(kDefaultChain);
  chain_->setObjectName("chain");
  chain_->setToolTip("the namespace of the chain");
  layout->addWidget(new QLabel("Chain"));
  layout->addWidget(chain_, 1);
  fit_ = new QPushButton("Fit view");
  fit_->setObjectName("fit_view");
  fit_->setCheckable(true);
  fit_->setToolTip("all of the map in the view, also as it grows, until you move the view");
  layout->addWidget(fit_);
  connect(fit_, &QPushButton::clicked, this, [this](bool is_checked) {
    if (fitter_ != nullptr) fitter_->setFollowing(is_checked);
    Q_EMIT configChanged();
  });
  connect(chain_, &QLineEdit::editingFinished, this, [this] {
    follow(chain_->text());
    Q_EMIT configChanged();
  });
  return row;
}

void SceneGraphPanel::onInitialize() {
  follow(chain_->text());
  fitter_ = new ViewFitter(*vis_manager_, this);
  connect(fitter_, &ViewFitter::followingChanged, fit_, &QPushButton::setChecked);
  if (is_fitting_) fitter_->setFollowing(true);
  auto* selection = vis_manager_->getSelectionManager()->getPropertyModel();
  connect(selection, SIGNAL(rowsInserted(QModelIndex, int, int)), this, SLOT(onSelectionChanged()));
  connect(selection, SIGNAL(rowsRemoved(QModelIndex, int, int)), this, SLOT(onSelectionChanged()));
}

void SceneGraphPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString chain;
  if (config.mapGetString("Chain", &chain)) chain_->setText(chain);
  config.mapGetBool("Fit View", &is_fitting_);
  if (vis_manager_ == nullptr) return;
  follow(chain_->text());
  fitter_->setFollowing(is_fitting_);
}

void SceneGraphPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Chain", chain_->text());
  config.mapSetValue("Fit View", fit_->isChecked());
}

void SceneGraphPanel::follow(const QString& text) {
  std::string chain = text.trimmed().toStdString();
  while (!chain.empty() && chain.back() == '/') chain.pop_back();
  if (!chain.empty() && chain.front() != '/') chain.insert(0, "/");
  stages_->setChain(chain);
  link_->follow(chain);
}

void SceneGraphPanel::lookAt(const std::string& frame, const geometry_msgs::Point& point) {
  if (vis_manager_ == nullptr) return;
  geometry_msgs::Pose pose;
  pose.position = point;
  pose.orientation.w = 1.0;
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  if (!vis_manager_->getFrameManager()->transform(frame, ros::Time(), pose, position,
                                                  orientation)) {
    return say("no transform from '" + frame + "' to rviz's fixed frame '" +
                   vis_manager_->getFixedFrame().toStdString() + "': the view cannot jump there",
               true);
  }
  fitter_->setFollowing(false);
  vis_manager_->getViewManager()->getCurrent()->lookAt(position);
  vis_manager_->queueRender();
}

void SceneGraphPanel::onSelectionChanged() {
  const auto* root = vis_manager_->getSelectionManager()->getPropertyModel()->getRoot();
  for (int i = 0; i < root->numChildren(); ++i) {
    const Selected selected = readMarkerName(root->childAt(i)->getName());
    if (selected.id == 0) continue;
    if (selected.name != selected_) questions_->explain(selected.what, selected.id, selected.name);
    if (selected.name != selected_) tabs_->setCurrentWidget(questions_);
    selected_ = selected.name;
    return;
  }
  selected_.clear();
}

void SceneGraphPanel::showScores(bool are_shown) {
  if (vis_manager_ == nullptr) return;
  const std::string topic = link_->chain() + "/scene_graph/question_markers";
  rviz::Display* display = findMarkerDisplay(*vis_manager_->getRootDisplayGroup(), topic);
  if (display != nullptr) return display->setEnabled(are_shown);
  if (!are_shown) return;
  display = vis_manager_->createDisplay("rviz/MarkerArray", "Scores of the last question", true);
  display->subProp("Marker Topic")->setValue(QString::fromStdString(topic));
}

void SceneGraphPanel::say(const std::string& text, bool is_error) {
  note_->setStyleSheet(is_error ? "color: #b03000" : "");
  note_->setText(QString::fromStdString(text));
}

}  // namespace tsg::rviz_plugin

PLUGINLIB_EXPORT_CLASS(tsg::rviz_plugin::SceneGraphPanel, rviz::Panel)

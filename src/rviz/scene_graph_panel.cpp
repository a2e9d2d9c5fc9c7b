// SPDX-License-Identifier: BSD-3-Clause
#include "scene_graph_panel.h"

#include <rviz/frame_manager.h>
#include <rviz/properties/property_tree_model.h>
#include <rviz/selection/selection_manager.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/visualization_manager.h>

#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QPushButton>
#include <QRegularExpression>
#include <QTabWidget>
#include <QVBoxLayout>
#include <pluginlib/class_list_macros.hpp>

namespace tsg::rviz_plugin {
namespace {

constexpr const char* kDefaultChain = "/task_scene_graph";

/// A thing of the graph that a marker's name tells of.
struct Selected {
  std::uint8_t what = 0;
  std::uint64_t id = 0;
  std::string name;
};

/// "Marker object_boxes/12" and "Marker regions/3"; id 0 for others.
Selected readMarkerName(const QString& name) {
  static const QRegularExpression pattern("^Marker (object|region)\\w*/(\\d+)$");
  const QRegularExpressionMatch match = pattern.match(name);
  if (!match.hasMatch() || name.contains("edges")) return {};
  const bool is_object = match.captured(1) == "object";
  const std::uint8_t what = is_object ? msg::ExplainRequest::OBJECT : msg::ExplainRequest::REGION;
  return {what, match.captured(2).toULongLong(),
          (match.captured(1) + " " + match.captured(2)).toStdString()};
}

}  // namespace

SceneGraphPanel::SceneGraphPanel(QWidget* parent) : rviz::Panel(parent) {
  link_ = std::make_unique<ChainLink>(makeHandlers());
  tasks_ = new TaskTab(*link_);
  questions_ =
      new QuestionTab(*link_, [this](const std::string& frame, const geometry_msgs::Point& point) {
        lookAt(frame, point);
      });
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
  layout->addWidget(makeButtons());
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
  connect(chain_, &QLineEdit::editingFinished, this, [this] {
    follow(chain_->text());
    Q_EMIT configChanged();
  });
  return row;
}

QWidget* SceneGraphPanel::makeButtons() {
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  const auto addButton = [&](const char* text, const char* service, const char* tip) {
    auto* button = new QPushButton(text);
    button->setObjectName(service);
    button->setToolTip(tip);
    layout->addWidget(button);
    return button;
  };
  for (auto* button : {addButton("Save", "save_map", "writes the map of now"),
                       addButton("Pause", "pause", "all stages stop taking in images"),
                       addButton("Resume", "resume", "all stages go on")}) {
    connect(button, &QPushButton::clicked, this,
            [this, button] { link_->trigger(button->objectName().toStdString()); });
  }
  auto* reset = addButton("Reset", "reset", "all stages forget what they have built");
  connect(reset, &QPushButton::clicked, this, [this] {
    const auto answer = QMessageBox::question(
        this, "Reset", "Forget the map? Tasks and parameters stay; what was not saved is lost.");
    if (answer == QMessageBox::Yes) link_->trigger("reset");
  });
  return row;
}

void SceneGraphPanel::onInitialize() {
  follow(chain_->text());
  auto* selection = vis_manager_->getSelectionManager()->getPropertyModel();
  connect(selection, SIGNAL(rowsInserted(QModelIndex, int, int)), this, SLOT(onSelectionChanged()));
  connect(selection, SIGNAL(rowsRemoved(QModelIndex, int, int)), this, SLOT(onSelectionChanged()));
}

void SceneGraphPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString chain;
  if (config.mapGetString("Chain", &chain)) chain_->setText(chain);
  if (vis_manager_ != nullptr) follow(chain_->text());
}

void SceneGraphPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Chain", chain_->text());
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

void SceneGraphPanel::say(const std::string& text, bool is_error) {
  note_->setStyleSheet(is_error ? "color: #b03000" : "");
  note_->setText(QString::fromStdString(text));
}

}  // namespace tsg::rviz_plugin

PLUGINLIB_EXPORT_CLASS(tsg::rviz_plugin::SceneGraphPanel, rviz::Panel)

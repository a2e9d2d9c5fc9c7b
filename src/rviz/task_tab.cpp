// SPDX-License-Identifier: BSD-3-Clause
#include "task_tab.h"

#include <QComboBox>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QIcon>
#include <QLabel>
#include <QLineEdit>
#include <QPixmap>
#include <QPushButton>
#include <QSlider>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <cmath>
#include <cstdlib>

#include "delta_scale.h"

namespace tsg::rviz_plugin {
namespace {

constexpr int kAlphaSteps = 1000;
constexpr int kSendPeriod_ms = 60;

QIcon makeIcon(const std_msgs::ColorRGBA& color) {
  QPixmap square(12, 12);
  square.fill(QColor::fromRgbF(static_cast<double>(color.r), static_cast<double>(color.g),
                               static_cast<double>(color.b)));
  return QIcon(square);
}

QSlider* makeSlider(const QString& name, int max_step) {
  auto* slider = new QSlider(Qt::Horizontal);
  slider->setObjectName(name);
  slider->setRange(0, max_step);
  return slider;
}

}  // namespace

TaskTab::TaskTab(ChainLink& link, QWidget* parent) : QWidget(parent), link_(link) {
  layer_ = new QComboBox;
  layer_->setObjectName("layer");
  layer_->addItems({"Tasks of objects", "Tasks of places"});
  list_ = new QTreeWidget;
  list_->setObjectName("tasks");
  list_->setHeaderLabels({"task", "serve it"});
  list_->setRootIsDecorated(false);
  list_->setSelectionMode(QAbstractItemView::ExtendedSelection);
  list_->header()->setStretchLastSection(false);
  list_->header()->setSectionResizeMode(0, QHeaderView::Stretch);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(layer_);
  layout->addWidget(list_, 1);
  layout->addWidget(makeEntry());
  layout->addWidget(makeSliders());
  moved_.setSingleShot(true);
  moved_.setInterval(kSendPeriod_ms);
  connect(&moved_, &QTimer::timeout, this, [this] { sendMoved(); });
  connect(layer_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this](int) {
    showTasks();
    showValues();
  });
}

QWidget* TaskTab::makeEntry() {
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  entry_ = new QLineEdit;
  entry_->setObjectName("new_task");
  entry_->setPlaceholderText("a task in plain words");
  auto* add = new QPushButton("Add");
  add->setObjectName("add_task");
  auto* remove = new QPushButton("Remove");
  remove->setObjectName("remove_task");
  remove->setToolTip("takes the selected tasks out");
  layout->addWidget(entry_, 1);
  layout->addWidget(add);
  layout->addWidget(remove);
  connect(entry_, &QLineEdit::returnPressed, this, [this] { addTyped(); });
  connect(add, &QPushButton::clicked, this, [this] { addTyped(); });
  connect(remove, &QPushButton::clicked, this, [this] { removeSelected(); });
  return row;
}

QWidget* TaskTab::makeSliders() {
  auto* box = new QWidget;
  auto* layout = new QGridLayout(box);
  layout->setContentsMargins(0, 0, 0, 0);
  alpha_ = makeSlider("alpha", kAlphaSteps);
  alpha_->setToolTip("cosine below which a thing is irrelevant to a task");
  delta_ = makeSlider("delta", DeltaScale::kSteps);
  delta_->setToolTip("how much information one merge may lose: to the right, things grow together");
  alpha_label_ = new QLabel;
  delta_label_ = new QLabel;
  layout->addWidget(alpha_label_, 0, 0);
  layout->addWidget(alpha_, 0, 1);
  layout->addWidget(delta_label_, 1, 0);
  layout->addWidget(delta_, 1, 1);
  layout->setColumnStretch(1, 1);
  for (auto* slider : {alpha_, delta_}) {
    connect(slider, &QSlider::valueChanged, this, [this](int) { onMoved(); });
  }
  showValues();
  return box;
}

bool TaskTab::isForPlaces() const { return layer_->currentIndex() == 1; }

std::string TaskTab::alphaName() const { return isForPlaces() ? "place_alpha" : "object_alpha"; }

std::string TaskTab::deltaName() const {
  const std::string layer = isForPlaces() ? "place_" : "object_";
  const auto normaliser = settings_.find(layer + "normaliser");
  const bool is_in_bits = normaliser != settings_.end() &&
                          normaliser->second.find("size_invariant") != std::string::npos;
  return layer + (is_in_bits ? "delta_bits" : "delta");
}

void TaskTab::change(std::uint8_t action, const std::string& name) {
  msg::ChangeTasksRequest request;
  request.action = action;
  request.layer =
      isForPlaces() ? msg::ChangeTasksRequest::PLACES : msg::ChangeTasksRequest::OBJECTS;
  request.tasks.resize(1);
  request.tasks.front().name = name;
  link_.changeTasks(request);
}

void TaskTab::addTyped() {
  const QString words = entry_->text().trimmed();
  if (words.isEmpty()) return;
  change(msg::ChangeTasksRequest::ADD, words.toStdString());
  entry_->clear();
}

void TaskTab::removeSelected() {
  msg::ChangeTasksRequest request;
  request.action = msg::ChangeTasksRequest::REMOVE;
  request.layer =
      isForPlaces() ? msg::ChangeTasksRequest::PLACES : msg::ChangeTasksRequest::OBJECTS;
  for (const auto* item : list_->selectedItems()) {
    request.tasks.emplace_back();
    request.tasks.back().name = item->text(0).toStdString();
  }
  if (!request.tasks.empty()) link_.changeTasks(request);
}

void TaskTab::setTasks(const msg::TasksInForce& tasks) {
  tasks_ = tasks;
  showTasks();
}

void TaskTab::showTasks() {
  const QStringList selected = [this] {
    QStringList names;
    for (const auto* item : list_->selectedItems()) names.append(item->text(0));
    return names;
  }();
  list_->clear();
  for (const auto& task : isForPlaces() ? tasks_.place_tasks : tasks_.object_tasks) {
    auto* item = new QTreeWidgetItem(
        list_, {QString::fromStdString(task.name), QString::number(task.count)});
    if (!isForPlaces())
      item->setIcon(0, makeIcon(task.color));  // regions have colours of their own
    item->setTextAlignment(1, Qt::AlignRight);
    item->setSelected(selected.contains(item->text(0)));
  }
  entry_->setEnabled(tasks_.can_encode != 0);
  entry_->setToolTip(tasks_.can_encode != 0
                         ? QString()
                         : QString("the chain has no text encoder: its model set has none"));
}

void TaskTab::setSettings(const msg::StageSettings& settings) {
  settings_.clear();
  for (const auto& setting : settings.settings) settings_[setting.name] = setting.value;
  showValues();
}

double TaskTab::valueOf(const std::string& name) const {
  const auto found = settings_.find(name);
  return found == settings_.end() ? 0.0 : std::strtod(found->second.c_str(), nullptr);
}

void TaskTab::showValues() {
  const bool is_held = alpha_->isSliderDown() || delta_->isSliderDown() || moved_.isActive();
  if (!is_held) {
    const QSignalBlocker no_alpha(alpha_);
    const QSignalBlocker no_delta(delta_);
    alpha_->setValue(static_cast<int>(std::lround(valueOf(alphaName()) * kAlphaSteps)));
    delta_->setValue(DeltaScale::toStep(valueOf(deltaName())));
  }
  const bool is_known = !settings_.empty();
  alpha_->setEnabled(is_known);
  delta_->setEnabled(is_known);
  const auto label = [&](const std::string& name, const char* text) {
    return is_known ? QString("%1 %2").arg(text).arg(valueOf(name), 0, 'g', 3) : QString(text);
  };
  alpha_label_->setText(label(alphaName(), "alpha"));
  delta_label_->setText(label(deltaName(), "delta"));
  delta_label_->setToolTip(QString::fromStdString(deltaName()));
}

void TaskTab::onMoved() {
  if (!moved_.isActive()) moved_.start();
}

void TaskTab::sendMoved() {
  const double alpha = static_cast<double>(alpha_->value()) / kAlphaSteps;
  if (alpha_->value() != std::lround(valueOf(alphaName()) * kAlphaSteps)) {
    link_.setParameter(alphaName(), alpha);
  }
  if (delta_->value() != DeltaScale::toStep(valueOf(deltaName()))) {
    link_.setParameter(deltaName(), DeltaScale::toDelta(delta_->value()));
  }
}

}  // namespace tsg::rviz_plugin

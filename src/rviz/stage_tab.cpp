// SPDX-License-Identifier: BSD-3-Clause
#include "stage_tab.h"

#include <QHeaderView>
#include <QPlainTextEdit>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <cstdlib>
#include <utility>

namespace tsg::rviz_plugin {
namespace {

using diagnostic_msgs::DiagnosticStatus;

const std::string kSuffix = ": stage";
const std::string kDropped = "dropped: ";
const std::string kHidden = "objects hidden";
const std::string kPlausibility = "plausibility: ";

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

double valueOf(const DiagnosticStatus& status, const std::string& key) {
  for (const auto& entry : status.values) {
    if (entry.key == key) return std::strtod(entry.value.c_str(), nullptr);
  }
  return 0.0;
}

double countDropped(const DiagnosticStatus& status) {
  double sum = 0.0;
  for (const auto& entry : status.values) {
    if (startsWith(entry.key, kDropped)) sum += std::strtod(entry.value.c_str(), nullptr);
  }
  return sum;
}

/// What an operator should know of a stage, a line each.
std::string describe(const std::string& name, const DiagnosticStatus& status) {
  std::string text;
  if (status.level != DiagnosticStatus::OK) text += name + ": " + status.message + "\n";
  for (const auto& entry : status.values) {
    if (startsWith(entry.key, kDropped)) text += name + " " + entry.key + ": " + entry.value + "\n";
    if (entry.key == kHidden && entry.value != "0") {
      text += name + ": not shown are " + entry.value + "\n";
    }
    if (startsWith(entry.key, kPlausibility) && entry.value != status.message) {
      text += name + " looks wrong: " + entry.value + "\n";
    }
  }
  return text;
}

}  // namespace

StageTab::StageTab(QWidget* parent) : QWidget(parent) {
  list_ = new QTreeWidget;
  list_->setObjectName("stages");
  list_->setHeaderLabels({"stage", "per s", "dropped", "ms"});
  list_->setRootIsDecorated(false);
  lines_ = new QPlainTextEdit;
  lines_->setObjectName("findings");
  lines_->setReadOnly(true);
  lines_->setPlaceholderText("drops, and what looks wrong with the input");
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(list_, 1);
  layout->addWidget(lines_, 1);
}

void StageTab::setChain(const std::string& chain) {
  prefix_ = chain.substr(chain.find_first_not_of('/') == std::string::npos ? chain.size() : 1);
  if (!prefix_.empty()) prefix_ += "/";
  stages_.clear();
  showStages();
}

void StageTab::add(const diagnostic_msgs::DiagnosticArray& message) {
  const auto now = std::chrono::steady_clock::now();
  bool is_ours = false;
  for (const auto& status : message.status) {
    const std::string& name = status.name;
    if (!startsWith(name, prefix_) || name.size() < prefix_.size() + kSuffix.size()) continue;
    if (name.compare(name.size() - kSuffix.size(), kSuffix.size(), kSuffix) != 0) continue;
    Stage& stage =
        stages_[name.substr(prefix_.size(), name.size() - prefix_.size() - kSuffix.size())];
    const double processed = valueOf(status, "processed");
    const std::chrono::duration<double> passed = now - stage.last;
    if (passed.count() > 0.0) stage.rate_hz = (processed - stage.processed) / passed.count();
    stage.status = status;
    stage.processed = processed;
    stage.last = now;
    is_ours = true;
  }
  if (is_ours) showStages();
}

void StageTab::showStages() {
  list_->clear();
  std::string text;
  for (const auto& [name, stage] : stages_) {
    auto* item = new QTreeWidgetItem(
        list_, {QString::fromStdString(name), QString::number(stage.rate_hz, 'f', 1),
                QString::number(countDropped(stage.status), 'f', 0),
                QString::number(valueOf(stage.status, "ms mean"), 'f', 1)});
    item->setToolTip(0, QString::fromStdString(stage.status.message));
    if (stage.status.level != DiagnosticStatus::OK) item->setForeground(0, QColor(190, 90, 0));
    text += describe(name, stage.status);
  }
  for (int column = 0; column < list_->columnCount(); ++column)
    list_->resizeColumnToContents(column);
  const QString shown = QString::fromStdString(text);
  if (lines_->toPlainText() != shown) lines_->setPlainText(shown);
}

}  // namespace tsg::rviz_plugin

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>

#include <QWidget>
#include <chrono>
#include <map>
#include <string>

class QPlainTextEdit;
class QTreeWidget;

namespace tsg::rviz_plugin {

/// What the stages of a chain say in /diagnostics: how much they do a second, what they drop and
/// why, and what looks wrong with the input.
class StageTab : public QWidget {
 public:
  explicit StageTab(QWidget* parent = nullptr);

  /// Forgets the chain before.
  void setChain(const std::string& chain);
  void add(const diagnostic_msgs::DiagnosticArray& message);

 private:
  struct Stage {
    diagnostic_msgs::DiagnosticStatus status;
    double processed = 0.0;
    double rate_hz = 0.0;
    std::chrono::steady_clock::time_point last;
  };

  void showStages();

  std::string prefix_;
  std::map<std::string, Stage> stages_;
  QTreeWidget* list_;
  QPlainTextEdit* lines_;
};

}  // namespace tsg::rviz_plugin

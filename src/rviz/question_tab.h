// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <QWidget>
#include <functional>
#include <string>

#include "chain_link.h"

class QLabel;
class QLineEdit;
class QPlainTextEdit;
class QTreeWidget;
class QTreeWidgetItem;

namespace tsg::rviz_plugin {

/// Questions in words with their answers, best first; the view jumps to the one that is chosen, and
/// why it is clustered as it is stands below.
class QuestionTab : public QWidget {
 public:
  /// A point of the map that the view should look at.
  using Look = std::function<void(const std::string& frame, const geometry_msgs::Point& point)>;
  /// Whether the view should show the scores of the last question.
  using ShowScores = std::function<void(bool)>;

  QuestionTab(ChainLink& link, Look look, ShowScores show_scores, QWidget* parent = nullptr);

  void setAnswers(const msg::AskResponse& answers);
  void setExplanation(const std::string& text);
  /// Of the chosen thing, rgb8; empty: there is none.
  void setPicture(const sensor_msgs::Image& picture);
  /// Shows why an object, primitive or region is as it is, chosen in the view.
  void explain(std::uint8_t what, std::uint64_t id, const std::string& name);

 private:
  void ask();
  void addAnswer(const char* kind, int what, const msg::Answer& answer);
  void choose(const QTreeWidgetItem& item);
  QLayout* makeExplanation();

  ChainLink& link_;
  Look look_;
  msg::AskResponse answers_;
  QLineEdit* words_;
  QTreeWidget* list_;
  QPlainTextEdit* explanation_;
  QLabel* picture_;
};

}  // namespace tsg::rviz_plugin

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <QTimer>
#include <QWidget>
#include <map>
#include <string>

#include "chain_link.h"

class QComboBox;
class QLabel;
class QLineEdit;
class QSlider;
class QTreeWidget;

namespace tsg::rviz_plugin {

/// The tasks in force with their colours and counts, of objects or of places; new ones by typing;
/// alpha and delta of that layer as sliders, delta on a logarithmic scale.
class TaskTab : public QWidget {
 public:
  explicit TaskTab(ChainLink& link, QWidget* parent = nullptr);

  void setTasks(const msg::TasksInForce& tasks);
  /// Values in force; a slider that is being moved stays where it is.
  void setSettings(const msg::StageSettings& settings);

 private:
  QWidget* makeEntry();
  QWidget* makeSliders();
  void change(std::uint8_t action, const std::string& name);
  void addTyped();
  void removeSelected();
  bool isForPlaces() const;
  /// "object_delta", or "object_delta_bits" where that is what counts.
  std::string deltaName() const;
  std::string alphaName() const;
  void onMoved();
  void sendMoved();
  void showTasks();
  void showValues();
  double valueOf(const std::string& name) const;

  ChainLink& link_;
  msg::TasksInForce tasks_;
  std::map<std::string, std::string> settings_;
  QComboBox* layer_;
  QTreeWidget* list_;
  QLineEdit* entry_;
  QSlider* alpha_;
  QSlider* delta_;
  QLabel* alpha_label_;
  QLabel* delta_label_;
  QTimer moved_;  ///< a slider's steps are sent together, so often as a call takes
};

}  // namespace tsg::rviz_plugin

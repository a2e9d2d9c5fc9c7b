// SPDX-License-Identifier: BSD-3-Clause
#include "map_buttons.h"

#include <QCheckBox>
#include <QDialog>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QPushButton>
#include <QVBoxLayout>

namespace tsg::rviz_plugin {
namespace {

/// Of the folder of a map. The robot may be another machine, so it can be typed, too.
QWidget* makeFolderRow(QLineEdit* folder) {
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  auto* browse = new QPushButton("Browse...");
  browse->setAutoDefault(false);
  layout->addWidget(folder, 1);
  layout->addWidget(browse);
  QObject::connect(browse, &QPushButton::clicked, row, [row, folder] {
    const QString chosen =
        QFileDialog::getExistingDirectory(row, "Folder of a map", folder->text());
    if (!chosen.isEmpty()) folder->setText(chosen);
  });
  return row;
}

}  // namespace

MapButtons::MapButtons(ChainLink& link, QWidget* parent) : QWidget(parent), link_(link) {
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->setSpacing(2);
  for (auto* button : {addButton("Save", "save_map", "writes the map of now"),
                       addButton("Pause", "pause", "all stages stop taking in images"),
                       addButton("Resume", "resume", "all stages go on")}) {
    connect(button, &QPushButton::clicked, this,
            [this, button] { link_.trigger(button->objectName().toStdString()); });
  }
  auto* load = addButton("Load", "load_map", "a saved map takes the place of that of now");
  layout->insertWidget(1, load);
  connect(load, &QPushButton::clicked, this, [this] { askForMap(); });
  auto* reset = addButton("Reset", "reset", "all stages forget what they have built");
  connect(reset, &QPushButton::clicked, this, [this] { askForReset(); });
}

QPushButton* MapButtons::addButton(const char* text, const char* service, const char* tip) {
  auto* button = new QPushButton(text);
  button->setObjectName(service);
  button->setToolTip(tip);
  button->setMinimumWidth(40);
  layout()->addWidget(button);
  return button;
}

void MapButtons::askForMap() {
  auto* dialog = new QDialog(this);
  dialog->setObjectName("load_dialog");
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle("Load a map");
  auto* folder = new QLineEdit(folder_);
  folder->setObjectName("map_folder");
  auto* with_tasks = new QCheckBox("take its tasks, too");
  with_tasks->setObjectName("with_tasks");
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Open | QDialogButtonBox::Cancel);
  buttons->button(QDialogButtonBox::Open)->setDefault(true);
  auto* layout = new QVBoxLayout(dialog);
  layout->addWidget(
      new QLabel("Folder of the map, on the robot's machine. What was not saved is lost."));
  layout->addWidget(makeFolderRow(folder));
  layout->addWidget(with_tasks);
  layout->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, dialog, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, dialog, &QDialog::reject);
  connect(dialog, &QDialog::accepted, this, [this, folder, with_tasks] {
    folder_ = folder->text().trimmed();
    link_.loadMap(folder_.toStdString(), with_tasks->isChecked());
  });
  dialog->resize(480, dialog->sizeHint().height());
  dialog->open();  // rviz goes on
}

void MapButtons::askForReset() {
  auto* question =
      new QMessageBox(QMessageBox::Question, "Reset",
                      "Forget the map? Tasks and parameters stay; what was not saved is lost.",
                      QMessageBox::Yes | QMessageBox::No, this);
  question->setObjectName("reset_dialog");
  question->setAttribute(Qt::WA_DeleteOnClose);
  connect(question, &QMessageBox::finished, this, [this](int answer) {
    if (answer == QMessageBox::Yes) link_.trigger("reset");
  });
  question->open();
}

}  // namespace tsg::rviz_plugin

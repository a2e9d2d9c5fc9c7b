// SPDX-License-Identifier: BSD-3-Clause
#include "question_tab.h"

#include <task_scene_graph/GetObject.h>

#include <QCheckBox>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QImage>
#include <QLabel>
#include <QLineEdit>
#include <QPixmap>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>
#include <vector>

namespace tsg::rviz_plugin {
namespace {

constexpr int kNoReason = -1;  ///< places: an explanation takes two
constexpr int kPicture_px = 96;
enum Role { kWhat = Qt::UserRole, kId, kX, kY, kZ };

}  // namespace

QuestionTab::QuestionTab(ChainLink& link, Look look, ShowScores show_scores, QWidget* parent)
    : QWidget(parent), link_(link), look_(std::move(look)) {
  words_ = new QLineEdit;
  words_->setObjectName("question");
  words_->setPlaceholderText("what is looked for: coffee mug");
  auto* button = new QPushButton("Ask");
  button->setObjectName("ask");
  list_ = new QTreeWidget;
  list_->setObjectName("answers");
  list_->setHeaderLabels({"answer", "score", "serves", "in"});
  list_->setRootIsDecorated(false);
  auto* scores = new QCheckBox("scores in the view");
  scores->setObjectName("show_scores");
  scores->setToolTip("everything in the map coloured by how well it fits the last question");
  auto* row = new QHBoxLayout;
  row->addWidget(words_, 1);
  row->addWidget(button);
  auto* layout = new QVBoxLayout(this);
  layout->addLayout(row);
  layout->addWidget(list_, 2);
  layout->addWidget(scores);
  layout->addLayout(makeExplanation(), 1);
  connect(words_, &QLineEdit::returnPressed, this, [this] { ask(); });
  connect(button, &QPushButton::clicked, this, [this] { ask(); });
  connect(scores, &QCheckBox::toggled, this, std::move(show_scores));
  connect(list_, &QTreeWidget::currentItemChanged, this,
          [this](QTreeWidgetItem* item, QTreeWidgetItem*) {
            if (item != nullptr) choose(*item);
          });
}

QLayout* QuestionTab::makeExplanation() {
  explanation_ = new QPlainTextEdit;
  explanation_->setObjectName("explanation");
  explanation_->setReadOnly(true);
  explanation_->setPlaceholderText("why the chosen thing is as it is");
  picture_ = new QLabel;
  picture_->setObjectName("picture");
  picture_->setAlignment(Qt::AlignTop);
  picture_->hide();
  auto* row = new QHBoxLayout;
  row->addWidget(picture_);
  row->addWidget(explanation_, 1);
  return row;
}

void QuestionTab::ask() {
  const QString words = words_->text().trimmed();
  if (!words.isEmpty()) link_.ask(words.toStdString());
}

void QuestionTab::setAnswers(const msg::AskResponse& answers) {
  struct Entry {
    const char* kind;
    int what;
    const msg::Answer* answer;
  };
  answers_ = answers;
  std::vector<Entry> entries;
  const auto gather = [&](const char* kind, int what, const std::vector<msg::Answer>& list) {
    for (const auto& answer : list) entries.push_back({kind, what, &answer});
  };
  gather("object", msg::ExplainRequest::OBJECT, answers_.objects);
  gather("primitive", msg::ExplainRequest::PRIMITIVE, answers_.primitives);
  gather("region", msg::ExplainRequest::REGION, answers_.regions);
  gather("place", kNoReason, answers_.places);
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.answer->score > b.answer->score;
  });
  list_->clear();
  for (const Entry& entry : entries) addAnswer(entry.kind, entry.what, *entry.answer);
  for (int column = 0; column < list_->columnCount(); ++column)
    list_->resizeColumnToContents(column);
  if (!entries.empty()) list_->setCurrentItem(list_->topLevelItem(0));
}

void QuestionTab::addAnswer(const char* kind, int what, const msg::Answer& answer) {
  std::string region;
  if (answer.region != 0) region = "region " + std::to_string(answer.region);
  if (!answer.region_task.empty()) region += " (" + answer.region_task + ")";
  auto* item = new QTreeWidgetItem(
      list_, {QString("%1 %2").arg(kind).arg(answer.id),
              QString::number(static_cast<double>(answer.score), 'f', 3),
              QString::fromStdString(answer.task), QString::fromStdString(region)});
  item->setData(0, kWhat, what);
  item->setData(0, kId, static_cast<qulonglong>(answer.id));
  item->setData(0, kX, answer.pose.position.x);
  item->setData(0, kY, answer.pose.position.y);
  item->setData(0, kZ, answer.pose.position.z);
}

void QuestionTab::choose(const QTreeWidgetItem& item) {
  geometry_msgs::Point point;
  point.x = item.data(0, kX).toDouble();
  point.y = item.data(0, kY).toDouble();
  point.z = item.data(0, kZ).toDouble();
  look_(answers_.header.frame_id, point);
  const int what = item.data(0, kWhat).toInt();
  if (what == kNoReason) {
    setExplanation("");
    return setPicture({});
  }
  explain(static_cast<std::uint8_t>(what), item.data(0, kId).toULongLong(),
          item.text(0).toStdString());
}

void QuestionTab::explain(std::uint8_t what, std::uint64_t id, const std::string& name) {
  setExplanation(name + " ...");
  setPicture({});
  link_.explain(what, id);
  if (what == msg::ExplainRequest::OBJECT) link_.showPicture(msg::GetObjectRequest::OBJECT, id);
  if (what == msg::ExplainRequest::PRIMITIVE) {
    link_.showPicture(msg::GetObjectRequest::PRIMITIVE, id);
  }
}

void QuestionTab::setPicture(const sensor_msgs::Image& picture) {
  const bool is_there = picture.encoding == "rgb8" && picture.width > 0 &&
                        picture.data.size() >= std::size_t{picture.step} * picture.height;
  picture_->setVisible(is_there);
  if (!is_there) return picture_->clear();
  const QImage image(picture.data.data(), static_cast<int>(picture.width),
                     static_cast<int>(picture.height), static_cast<int>(picture.step),
                     QImage::Format_RGB888);
  picture_->setPixmap(QPixmap::fromImage(image).scaled(
      kPicture_px, kPicture_px, Qt::KeepAspectRatio, Qt::SmoothTransformation));
}

void QuestionTab::setExplanation(const std::string& text) {
  explanation_->setPlainText(QString::fromStdString(text));
}

}  // namespace tsg::rviz_plugin

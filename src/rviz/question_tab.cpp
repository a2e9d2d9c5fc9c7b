// SPDX-License-Identifier: BSD-3-Clause
#include "question_tab.h"

#include <QHBoxLayout>
#include <QHeaderView>
#include <QLineEdit>
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
enum Role { kWhat = Qt::UserRole, kId, kX, kY, kZ };

}  // namespace

QuestionTab::QuestionTab(ChainLink& link, Look look, QWidget* parent)
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
  explanation_ = new QPlainTextEdit;
  explanation_->setObjectName("explanation");
  explanation_->setReadOnly(true);
  explanation_->setPlaceholderText("why the chosen thing is as it is");
  auto* row = new QHBoxLayout;
  row->addWidget(words_, 1);
  row->addWidget(button);
  auto* layout = new QVBoxLayout(this);
  layout->addLayout(row);
  layout->addWidget(list_, 2);
  layout->addWidget(explanation_, 1);
  connect(words_, &QLineEdit::returnPressed, this, [this] { ask(); });
  connect(button, &QPushButton::clicked, this, [this] { ask(); });
  connect(list_, &QTreeWidget::currentItemChanged, this,
          [this](QTreeWidgetItem* item, QTreeWidgetItem*) {
            if (item != nullptr) choose(*item);
          });
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
  if (what == kNoReason) return setExplanation("");
  link_.explain(static_cast<std::uint8_t>(what), item.data(0, kId).toULongLong());
}

void QuestionTab::explain(std::uint8_t what, std::uint64_t id, const std::string& name) {
  setExplanation(name + " ...");
  link_.explain(what, id);
}

void QuestionTab::setExplanation(const std::string& text) {
  explanation_->setPlainText(QString::fromStdString(text));
}

}  // namespace tsg::rviz_plugin

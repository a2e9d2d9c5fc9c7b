// SPDX-License-Identifier: BSD-3-Clause
// rviz itself, without a screen, with the panel in it: used as a person would, with keys and
// clicks.
#include <OgreCamera.h>
#include <gtest/gtest.h>
#include <rviz/display.h>
#include <rviz/display_group.h>
#include <rviz/properties/property.h>
#include <rviz/properties/property_tree_model.h>
#include <rviz/render_panel.h>
#include <rviz/selection/selection_manager.h>
#include <rviz/tool.h>
#include <rviz/tool_manager.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/visualization_frame.h>
#include <rviz/visualization_manager.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <visualization_msgs/MarkerArray.h>

#include <QApplication>
#include <QCheckBox>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QPixmap>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QScreen>
#include <QSlider>
#include <QTabWidget>
#include <QTest>
#include <QTreeWidget>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "../unit/segmentation/networks.h"
#include "rviz/find_display.h"
#include "support.h"
#include "synthetic_robot.h"
#include "task_scene_graph/language/word_encoder.h"

namespace tsg::test {
namespace {

const std::vector<std::string> kThings = {"mug", "book", "chair", "potted plant"};  // along x

std::string modelsPath() { return std::string(TSG_SOURCE_DIR) + "/models/demo/models.yaml"; }

/// Looks again while rviz goes on; false after the deadline.
bool waitInGui(const std::function<bool()>& predicate, double timeout_s = 60.0) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  while (!predicate()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    QTest::qWait(20);
  }
  return true;
}

#if QT_VERSION < QT_VERSION_CHECK(5, 15, 0)
const QPixmap* pictureOf(const QLabel* label) { return label->pixmap(); }
#else
const QPixmap* pictureOf(const QLabel* label) {
  static QPixmap picture;
  picture = label->pixmap(Qt::ReturnByValue);
  return &picture;
}
#endif

/// One primitive for each thing, two metres apart, its embedding that of its name.
msg::ObjectPrimitivesPtr makeMap() {
  language::WordEncoder encoder(modelsPath());
  const EmbeddingMatrix embeddings = encoder.encode(kThings);
  std::vector<ObjectPrimitivePtr> primitives;
  for (std::size_t i = 0; i < kThings.size(); ++i) {
    auto primitive = std::make_shared<ObjectPrimitive>();
    primitive->id = {i + 1};
    primitive->track = {i + 1};
    const double x_m = 2.0 * static_cast<double>(i);
    primitive->box = makeAabb({x_m, 0, 0}, {x_m + 1, 1, 1});
    primitive->oriented_box = toOrientedBox(primitive->box);
    primitive->first_seen = primitive->last_seen = Stamp::fromSeconds(10.0);
    primitive->thumbnail.image = cv::Mat(24, 32, CV_8UC3, cv::Scalar(40.0 * x_m, 90, 160));
    primitive->embedding = embeddings.row(static_cast<Eigen::Index>(i)).transpose();
    primitives.push_back(primitive);
  }
  return ros_interface::toMessage(primitives, Stamp::fromSeconds(10.0), "world");
}

class Panel : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!segmentation::findEngineObstacle().empty()) return;
    state_ = new State;
    state_->primitives = ros::NodeHandle().advertise<msg::ObjectPrimitives>(
        "/task_scene_graph/object_primitives", 1, true);
    state_->primitives.publish(makeMap());
    state_->frame.setShowChooseNewMaster(false);
    state_->frame.setSplashPath("");
    state_->frame.initialize(QString(TSG_SOURCE_DIR) + "/rviz/default.rviz");
    state_->frame.resize(1400, 950);
    state_->frame.show();
  }
  static void TearDownTestSuite() {
    delete state_;
    state_ = nullptr;
  }
  void SetUp() override {
    if (state_ == nullptr) GTEST_SKIP() << segmentation::findEngineObstacle();
    ASSERT_NE(find<QTabWidget>("tabs"), nullptr) << "rviz has not loaded the panel";
    ASSERT_TRUE(waitInGui([] { return countsOfTasks()["mug"] == "1"; }));
  }

  template <typename Widget>
  static Widget* find(const char* name) {
    return state_->frame.findChild<Widget*>(name);
  }
  static void showTab(int index) { find<QTabWidget>("tabs")->setCurrentIndex(index); }
  static void type(const char* field, const char* text) {
    auto* entry = find<QLineEdit>(field);
    entry->clear();
    QTest::keyClicks(entry, text);
    QTest::keyClick(entry, Qt::Key_Return);
  }
  static void click(const char* button) {
    QTest::mouseClick(find<QPushButton>(button), Qt::LeftButton);
  }
  static std::map<std::string, std::string> countsOfTasks() {
    std::map<std::string, std::string> counts;
    const auto* list = find<QTreeWidget>("tasks");
    for (int i = 0; i < list->topLevelItemCount(); ++i) {
      const auto* item = list->topLevelItem(i);
      counts[item->text(0).toStdString()] = item->text(1).toStdString();
    }
    return counts;
  }
  static std::set<std::string> tasksOfObjects() {
    std::set<std::string> tasks;
    const auto graphs = state_->graphs.messages();
    if (graphs.empty()) return tasks;
    for (const auto& object : graphs.back()->objects) tasks.insert(object.task);
    return tasks;
  }
  static rviz::Display* findDisplay(const std::string& topic) {
    return rviz_plugin::findMarkerDisplay(*state_->frame.getManager()->getRootDisplayGroup(),
                                          topic);
  }
  static rviz::Tool* findTool(const char* class_id) {
    rviz::ToolManager* tools = state_->frame.getManager()->getToolManager();
    for (int i = 0; i < tools->numTools(); ++i) {
      if (tools->getTool(i)->getClassId() == class_id) return tools->getTool(i);
    }
    return nullptr;
  }
  /// And lets rviz draw it.
  static void fitView() {
    auto* button = find<QPushButton>("fit_view");
    if (button->isChecked()) click("fit_view");
    click("fit_view");
    QTest::qWait(500);
  }
  static void loadMap(const std::string& folder) {
    click("load_map");
    ASSERT_TRUE(waitInGui([] { return find<QDialog>("load_dialog") != nullptr; }));
    auto* dialog = find<QDialog>("load_dialog");
    auto* entry = dialog->findChild<QLineEdit*>("map_folder");
    entry->clear();
    QTest::keyClicks(entry, QString::fromStdString(folder));
    takeScreenshot("panel_load");
    QTest::keyClick(entry, Qt::Key_Return);
    ASSERT_TRUE(waitInGui([] { return find<QDialog>("load_dialog") == nullptr; }));
  }
  static std::string note() { return find<QLabel>("note")->text().toStdString(); }
  /// Into $TSG_SCREENSHOTS, if that is set, to be looked at.
  static void takeScreenshot(const std::string& name) {
    const char* folder = std::getenv("TSG_SCREENSHOTS");
    if (folder == nullptr) return;
    QTest::qWait(2000);  // what is drawn lags behind
    const QPixmap screen = QGuiApplication::primaryScreen()->grabWindow(0);
    ASSERT_TRUE(screen.save(QString::fromStdString(std::string(folder) + "/" + name + ".png")));
  }

  struct State {
    ros::Publisher primitives;
    Recorder<msg::SceneGraph> graphs{"/task_scene_graph/scene_graph"};
    rviz::VisualizationFrame frame;
  };
  static State* state_;
};
Panel::State* Panel::state_ = nullptr;

TEST_F(Panel, ATaskThatIsTypedBringsItsObjectAndGoesAgain) {
  showTab(0);
  EXPECT_EQ(tasksOfObjects(), (std::set<std::string>{"mug", "book"}));
  takeScreenshot("panel_before");
  type("new_task", "potted plant");
  EXPECT_TRUE(waitInGui([] { return countsOfTasks()["potted plant"] == "1"; })) << note();
  EXPECT_TRUE(waitInGui([] { return tasksOfObjects().count("potted plant") == 1; }));
  takeScreenshot("panel_after");
  auto* list = find<QTreeWidget>("tasks");
  list->clearSelection();
  list->findItems("potted plant", Qt::MatchExactly).front()->setSelected(true);
  click("remove_task");
  EXPECT_TRUE(waitInGui([] { return countsOfTasks().count("potted plant") == 0; })) << note();
  EXPECT_TRUE(waitInGui([] { return tasksOfObjects().count("potted plant") == 0; }));
}

TEST_F(Panel, ATaskThatIsRefusedIsSaidAndTheListStays) {
  showTab(0);
  type("new_task", "mug");
  EXPECT_TRUE(waitInGui([] { return note().find("'mug' is in force") != std::string::npos; }))
      << note();
  EXPECT_EQ(countsOfTasks().size(), 2U);
}

TEST_F(Panel, TheViewJumpsToTheBestAnswerAndItIsExplained) {
  showTab(1);
  type("question", "chair");
  auto* answers = find<QTreeWidget>("answers");
  ASSERT_TRUE(waitInGui([&] { return answers->topLevelItemCount() > 0; })) << note();
  EXPECT_EQ(answers->topLevelItem(0)->text(0).toStdString(), "primitive 3");
  auto* focus = state_->frame.getManager()->getViewManager()->getCurrent()->subProp("Focal Point");
  EXPECT_NEAR(focus->subProp("X")->getValue().toDouble(), 4.5, 1e-3);
  EXPECT_NEAR(focus->subProp("Y")->getValue().toDouble(), 0.5, 1e-3);
  auto* explanation = find<QPlainTextEdit>("explanation");
  EXPECT_TRUE(waitInGui([&] {
    return explanation->toPlainText().startsWith("primitive 3: cosines");
  })) << explanation->toPlainText().toStdString();
  takeScreenshot("panel_ask");
}

TEST_F(Panel, AlphaAsASliderHidesWhatIsBelowAndBringsItBack) {
  showTab(0);
  auto* alpha = find<QSlider>("alpha");
  ASSERT_TRUE(waitInGui([&] { return alpha->value() == 500; }));
  type("new_task", "cup");  // other words for the mug: a cosine below 1
  ASSERT_TRUE(waitInGui([] { return countsOfTasks().count("cup") == 1; })) << note();
  alpha->setValue(1000);
  EXPECT_TRUE(waitInGui([] { return tasksOfObjects().empty(); }));
  alpha->setValue(500);
  EXPECT_TRUE(waitInGui([] { return tasksOfObjects().count("book") == 1; }));
  auto* list = find<QTreeWidget>("tasks");
  list->clearSelection();
  list->findItems("cup", Qt::MatchExactly).front()->setSelected(true);
  click("remove_task");
  EXPECT_TRUE(waitInGui([] { return countsOfTasks().count("cup") == 0; })) << note();
}

TEST_F(Panel, DeltaAsASliderIsSetOnItsLogarithmicScale) {
  showTab(0);
  Recorder<msg::StageSettings> settings("/task_scene_graph/scene_graph/settings");
  const auto valueOf = [&](const std::string& name) {
    const auto all = settings.messages();
    if (all.empty()) return std::nan("");
    for (const auto& setting : all.back()->settings) {
      if (setting.name == name) return std::atof(setting.value.c_str());
    }
    return std::nan("");
  };
  auto* delta = find<QSlider>("delta");
  ASSERT_TRUE(waitInGui([&] { return valueOf("object_delta") == 1e-5; }));
  EXPECT_EQ(delta->value(), 201);
  delta->setValue(401);
  EXPECT_TRUE(waitInGui([&] { return std::abs(valueOf("object_delta") - 1e-3) < 1e-9; }));
  delta->setValue(201);
  EXPECT_TRUE(waitInGui([&] { return std::abs(valueOf("object_delta") - 1e-5) < 1e-11; }));
}

TEST_F(Panel, AMarkerAmongTheSelectedThingsIsExplained) {
  showTab(0);
  find<QPlainTextEdit>("explanation")->clear();
  const std::uint64_t id = state_->graphs.messages().back()->objects.front().id;
  // What rviz lists of a marker that was picked with its tool Select.
  auto* selected = state_->frame.getManager()->getSelectionManager()->getPropertyModel()->getRoot();
  const QString name = QString("Marker object_boxes/%1").arg(id);
  auto* marker = new rviz::Property(name, QVariant(), "", selected);
  EXPECT_TRUE(waitInGui([] {
    return find<QPlainTextEdit>("explanation")->toPlainText().contains("serves '");
  })) << find<QPlainTextEdit>("explanation")->toPlainText().toStdString();
  EXPECT_EQ(find<QTabWidget>("tabs")->currentIndex(), 1);
  takeScreenshot("panel_selected");
  delete marker;
}

/// Where a point of the map is on rviz's picture, in pixels of its widget.
QPoint findOnScreen(rviz::VisualizationManager& manager, const Ogre::Vector3& p_world) {
  const Ogre::Camera& camera = *manager.getViewManager()->getCurrent()->getCamera();
  const Ogre::Vector3 p = camera.getProjectionMatrix() * (camera.getViewMatrix() * p_world);
  const QSize size = manager.getRenderPanel()->size();
  return {static_cast<int>((0.5F + 0.5F * p.x) * static_cast<float>(size.width())),
          static_cast<int>((0.5F - 0.5F * p.y) * static_cast<float>(size.height()))};
}

TEST_F(Panel, AClickOnABoxInTheViewShowsItWithItsPicture) {
  showTab(0);
  auto* explanation = find<QPlainTextEdit>("explanation");
  explanation->clear();
  rviz::VisualizationManager& manager = *state_->frame.getManager();
  fitView();
  const auto graph = state_->graphs.messages().back();
  const auto book = std::find_if(graph->objects.begin(), graph->objects.end(),
                                 [](const auto& object) { return object.task == "book"; });
  ASSERT_NE(book, graph->objects.end());
  rviz::Tool* select = findTool("rviz/Select");
  ASSERT_NE(select, nullptr);
  manager.getToolManager()->setCurrentTool(select);
  const auto& center = book->oriented_box.pose.position;
  const QPoint on_box = findOnScreen(
      manager, Ogre::Vector3(static_cast<float>(center.x), static_cast<float>(center.y),
                             static_cast<float>(center.z)));
  auto* panel = manager.getRenderPanel();
  ASSERT_TRUE(panel->rect().contains(on_box)) << on_box.x() << " " << on_box.y();
  const QPoint corner(4, 4);
  QTest::mousePress(panel, Qt::LeftButton, Qt::NoModifier, on_box - corner);
  QTest::mouseMove(panel, on_box + corner);
  QTest::mouseRelease(panel, Qt::LeftButton, Qt::NoModifier, on_box + corner);
  EXPECT_TRUE(waitInGui([&] { return explanation->toPlainText().contains("serves 'book'"); }))
      << explanation->toPlainText().toStdString();
  EXPECT_EQ(find<QTabWidget>("tabs")->currentIndex(), 1);
  EXPECT_TRUE(waitInGui([] {
    const QPixmap* picture = pictureOf(find<QLabel>("picture"));
    return find<QLabel>("picture")->isVisible() && picture != nullptr && !picture->isNull();
  }));
  takeScreenshot("panel_selected");
  manager.getToolManager()->setCurrentTool(findTool("rviz/Interact"));
}

TEST_F(Panel, TheFittedViewHoldsAllOfTheMapUntilItIsMoved) {
  rviz::VisualizationManager& manager = *state_->frame.getManager();
  auto* view = manager.getViewManager()->getCurrent();
  view->subProp("Distance")->setValue(1.0);
  fitView();
  auto* panel = manager.getRenderPanel();
  for (const float x : {0.0F, 3.0F}) {  // of the mug and the book, which are shown
    for (const float z : {0.0F, 3.0F}) {
      const QPoint on_screen = findOnScreen(manager, Ogre::Vector3(x, 0.5F, z));
      EXPECT_TRUE(panel->rect().contains(on_screen)) << on_screen.x() << " " << on_screen.y();
    }
  }
  EXPECT_TRUE(find<QPushButton>("fit_view")->isChecked());
  takeScreenshot("panel_fitted");
  view->subProp("Yaw")->setValue(1.0);
  EXPECT_TRUE(waitInGui([] { return !find<QPushButton>("fit_view")->isChecked(); }));
}

TEST_F(Panel, ScoresOfTheLastQuestionAreShownAndHiddenInTheView) {
  Recorder<visualization_msgs::MarkerArray> markers(
      "/task_scene_graph/scene_graph/question_markers");
  showTab(1);
  rviz::Display* display = findDisplay("/task_scene_graph/scene_graph/question_markers");
  ASSERT_NE(display, nullptr);
  EXPECT_FALSE(display->isEnabled());
  find<QCheckBox>("show_scores")->setChecked(true);
  EXPECT_TRUE(display->isEnabled());
  type("question", "chair");
  EXPECT_TRUE(waitInGui([&] {
    const auto all = markers.messages();
    return !all.empty() && std::any_of(all.back()->markers.begin(), all.back()->markers.end(),
                                       [](const auto& marker) {
                                         return marker.ns == "question_primitives" &&
                                                marker.id == 3 && marker.color.r == 1.0F;
                                       });
  })) << note();
  EXPECT_TRUE(waitInGui([&] { return display->subProp("Namespaces")->numChildren() >= 4; }));
  takeScreenshot("panel_scores");
  find<QCheckBox>("show_scores")->setChecked(false);
  EXPECT_FALSE(display->isEnabled());
}

TEST_F(Panel, AMapIsSavedForgottenAndLoadedAgain) {
  namespace fs = std::filesystem;
  std::string output;
  ASSERT_TRUE(ros::param::get("/task_scene_graph/scene_graph/output", output));
  showTab(0);
  click("save_map");
  ASSERT_TRUE(waitInGui([] { return note().find("save_map: done") != std::string::npos; }))
      << note();
  EXPECT_TRUE(fs::exists(fs::path(output) / "scene_graph.json"));
  click("reset");
  ASSERT_TRUE(waitInGui([] { return find<QMessageBox>("reset_dialog") != nullptr; }));
  QTest::mouseClick(find<QMessageBox>("reset_dialog")->button(QMessageBox::Yes), Qt::LeftButton);
  EXPECT_TRUE(waitInGui([] { return countsOfTasks()["mug"] == "0"; })) << note();
  loadMap("/no/such/map");
  EXPECT_TRUE(waitInGui([] {
    return note().find("load_map failed") != std::string::npos &&
           note().find("/no/such/map") != std::string::npos;
  })) << note();
  EXPECT_EQ(countsOfTasks()["mug"], "0");
  loadMap(output);
  EXPECT_TRUE(waitInGui([] { return countsOfTasks()["mug"] == "1"; })) << note();
  EXPECT_TRUE(waitInGui([] { return note().find("load_map: done") != std::string::npos; }))
      << note();
  takeScreenshot("panel_loaded");
  fs::remove_all(output);
}

TEST_F(Panel, AMapIsNotForgottenWithoutAYes) {
  click("reset");
  ASSERT_TRUE(waitInGui([] { return find<QMessageBox>("reset_dialog") != nullptr; }));
  takeScreenshot("panel_reset");
  QTest::mouseClick(find<QMessageBox>("reset_dialog")->button(QMessageBox::No), Qt::LeftButton);
  EXPECT_TRUE(waitInGui([] { return find<QMessageBox>("reset_dialog") == nullptr; }));
  EXPECT_EQ(countsOfTasks()["mug"], "1");
}

TEST_F(Panel, StagesShowTheirRates) {
  showTab(2);
  auto* stages = find<QTreeWidget>("stages");
  ASSERT_TRUE(waitInGui([&] { return stages->topLevelItemCount() == 1; }));
  EXPECT_EQ(stages->topLevelItem(0)->text(0).toStdString(), "scene_graph");
  takeScreenshot("panel_stages");
}

TEST_F(Panel, AMissingChainIsSaidAndRvizGoesOn) {
  type("chain", "/nobody");
  click("save_map");
  EXPECT_TRUE(waitInGui([] {
    return note().find("no service /nobody/scene_graph/save_map") != std::string::npos;
  })) << note();
  type("chain", "task_scene_graph/");
  click("pause");
  EXPECT_TRUE(waitInGui([] { return note().find("pause: done") != std::string::npos; })) << note();
  click("resume");
  EXPECT_TRUE(waitInGui([] { return note().find("resume: done") != std::string::npos; })) << note();
}

TEST_F(Panel, AServiceThatHangsDoesNotFreezeRviz) {
  std::atomic<bool> has_begun{false};
  std::atomic<bool> may_end{false};
  const boost::function<bool(msg::AskRequest&, msg::AskResponse&)> hang =
      [&](msg::AskRequest&, msg::AskResponse& response) {
        has_begun = true;
        response.success = waitUntil([&] { return may_end.load(); }, 30.0) ? 1 : 0;
        response.message = "woke up";
        return true;
      };
  ros::NodeHandle handle;
  const ros::ServiceServer server = handle.advertiseService("/slow/scene_graph/ask", hang);
  type("chain", "/slow");
  showTab(1);
  type("question", "chair");
  EXPECT_TRUE(waitInGui([&] { return has_begun.load(); }, 20.0));
  type("question", "still typing");
  EXPECT_EQ(find<QLineEdit>("question")->text().toStdString(), "still typing");
  EXPECT_EQ(note().find("woke up"), std::string::npos);
  may_end = true;
  EXPECT_TRUE(waitInGui([] { return note().find("woke up") != std::string::npos; })) << note();
  type("chain", "/task_scene_graph");
}

/// A display without a screen; its process ends with this one.
pid_t startDisplay() {
  int ends[2];
  if (pipe(ends) != 0) return -1;
  const pid_t pid = fork();
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    close(ends[0]);
    const std::string end = std::to_string(ends[1]);
    execlp("Xvfb", "Xvfb", "-displayfd", end.c_str(), "-screen", "0", "1400x950x24", "+extension",
           "GLX", "-nolisten", "tcp", nullptr);
    _exit(127);
  }
  close(ends[1]);
  std::string number;
  for (char digit = 0; read(ends[0], &digit, 1) == 1 && digit != '\n';) number += digit;
  close(ends[0]);
  if (number.empty()) return -1;
  setenv("DISPLAY", (":" + number).c_str(), 1);
  setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  setenv("QT_X11_NO_MITSHM", "1", 1);
  unsetenv("QT_QPA_PLATFORM");
  return pid;
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const pid_t display = tsg::test::startDisplay();
  if (display < 0) {
    std::cerr << "no Xvfb: it is in scripts/packages-*.txt\n";
    return 1;
  }
  ros::init(argc, argv, "rviz_panel_test", ros::init_options::NoSigintHandler);
  int result = 1;
  {
    QApplication application(argc, argv);
    ros::AsyncSpinner spinner(2);
    spinner.start();
    result = RUN_ALL_TESTS();
    spinner.stop();
  }
  kill(display, SIGTERM);
  waitpid(display, nullptr, 0);
  return result;
}

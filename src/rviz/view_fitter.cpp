// SPDX-License-Identifier: BSD-3-Clause
#include "view_fitter.h"

#include <OgreCamera.h>
#include <OgreSceneNode.h>
#include <OgreViewport.h>
#include <rviz/display_context.h>
#include <rviz/display_group.h>
#include <rviz/properties/property.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "view_fit.h"

namespace tsg::rviz_plugin {
namespace {

constexpr int kPeriod_ms = 500;
constexpr double kMargin = 1.06;
// The view follows only what has grown by more than this part of its size.
constexpr double kTolerance = 0.02;

bool showsTheMap(const rviz::Display& display) {
  static const std::set<QString> classes = {
      "task_scene_graph/Mesh", "rviz/Marker", "rviz/MarkerArray", "rviz/Map", "rviz/Path",
      "rviz/PointCloud2"};
  return classes.count(display.getClassId()) > 0;
}

void extend(Eigen::AlignedBox3d& box, const Ogre::AxisAlignedBox& other) {
  if (!other.isFinite()) return;
  const Ogre::Vector3& low = other.getMinimum();
  const Ogre::Vector3& high = other.getMaximum();
  box.extend(Eigen::Vector3d(low.x, low.y, low.z));
  box.extend(Eigen::Vector3d(high.x, high.y, high.z));
}

/// All that is drawn below a node, but texts: their size depends on the view.
void extend(Eigen::AlignedBox3d& box, Ogre::SceneNode& node) {
  for (unsigned short i = 0; i < node.numAttachedObjects(); ++i) {  // Ogre 1.9 and 1.12 have it
    const Ogre::MovableObject* object = node.getAttachedObject(i);
    const bool is_text = object->getMovableType() == "MovableText";
    if (!is_text && object->getVisible()) extend(box, object->getWorldBoundingBox(true));
  }
  for (unsigned short i = 0; i < node.numChildren(); ++i) {
    extend(box, *static_cast<Ogre::SceneNode*>(node.getChild(i)));
  }
}

void extend(Eigen::AlignedBox3d& box, const rviz::DisplayGroup& group) {
  for (int i = 0; i < group.numDisplays(); ++i) {
    const rviz::Display* display = group.getDisplayAt(i);
    if (!display->isEnabled()) continue;
    if (const auto* inner = qobject_cast<const rviz::DisplayGroup*>(display)) extend(box, *inner);
    if (showsTheMap(*display)) extend(box, *display->getSceneNode());
  }
}

const std::vector<const char*> kOrbit = {"Yaw", "Pitch", "Distance", "Focal Point"};
const std::vector<const char*> kTopDown = {"Scale", "Angle", "X", "Y"};

bool hasAll(rviz::ViewController& view, const std::vector<const char*>& names) {
  std::size_t count = 0;
  for (int i = 0; i < view.numChildren(); ++i) {
    const QString name = view.childAt(i)->getName();
    count += std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
  }
  return count == names.size();
}

std::vector<QVariant> readState(rviz::ViewController& view) {
  std::vector<QVariant> state{view.getClassId()};
  for (const auto* names : {&kOrbit, &kTopDown}) {
    if (!hasAll(view, *names)) continue;
    for (const char* name : *names) state.push_back(view.subProp(name)->getValue());
  }
  return state;
}

double valueOf(rviz::ViewController& view, const char* name) {
  return view.subProp(name)->getValue().toDouble();
}

}  // namespace

ViewFitter::ViewFitter(rviz::DisplayContext& context, QObject* parent)
    : QObject(parent), context_(context) {
  timer_.setInterval(kPeriod_ms);
  connect(&timer_, &QTimer::timeout, this, [this] { fitAgain(); });
}

void ViewFitter::setFollowing(bool is_following) {
  fitted_.setEmpty();
  if (is_following) {
    timer_.start();
    fit();
  } else {
    timer_.stop();
  }
  Q_EMIT followingChanged(is_following);
}

bool ViewFitter::fit() {
  rviz::ViewController* view = context_.getViewManager()->getCurrent();
  Eigen::AlignedBox3d box;
  extend(box, *context_.getRootDisplayGroup());
  if (view == nullptr || box.isEmpty()) return false;
  if (!fitOrbit(*view, box) && !fitTopDown(*view, box)) return false;
  fitted_ = box;
  state_ = readState(*view);
  context_.queueRender();
  return true;
}

void ViewFitter::fitAgain() {
  rviz::ViewController* view = context_.getViewManager()->getCurrent();
  if (fitted_.isEmpty()) {
    fit();
    return;
  }
  if (view == nullptr || readState(*view) != state_) return setFollowing(false);
  Eigen::AlignedBox3d box;
  extend(box, *context_.getRootDisplayGroup());
  const Eigen::Vector3d slack = Eigen::Vector3d::Constant(kTolerance * fitted_.diagonal().norm());
  const Eigen::AlignedBox3d fits(fitted_.min() - slack, fitted_.max() + slack);
  if (!box.isEmpty() && !fits.contains(box)) fit();
}

bool ViewFitter::fitOrbit(rviz::ViewController& view, const Eigen::AlignedBox3d& box) const {
  if (!hasAll(view, kOrbit)) return false;
  const Ogre::Camera& camera = *view.getCamera();
  const OrbitView fitted =
      fitOrbitView(box, valueOf(view, "Yaw"), valueOf(view, "Pitch"),
                   std::tan(0.5 * static_cast<double>(camera.getFOVy().valueRadians())),
                   static_cast<double>(camera.getAspectRatio()), kMargin);
  rviz::Property* focus = view.subProp("Focal Point");
  focus->subProp("X")->setValue(fitted.focal_point_m.x());
  focus->subProp("Y")->setValue(fitted.focal_point_m.y());
  focus->subProp("Z")->setValue(fitted.focal_point_m.z());
  view.subProp("Distance")->setValue(fitted.distance_m);
  return true;
}

bool ViewFitter::fitTopDown(rviz::ViewController& view, const Eigen::AlignedBox3d& box) const {
  const Ogre::Viewport* viewport = view.getCamera()->getViewport();
  if (!hasAll(view, kTopDown) || viewport == nullptr) return false;
  view.subProp("Scale")->setValue(fitScale(box, valueOf(view, "Angle"), viewport->getActualWidth(),
                                           viewport->getActualHeight(), kMargin));
  view.subProp("X")->setValue(box.center().x());
  view.subProp("Y")->setValue(box.center().y());
  return true;
}

}  // namespace tsg::rviz_plugin

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <QObject>
#include <QTimer>
#include <QVariant>
#include <vector>

namespace rviz {
class DisplayContext;
class ViewController;
}  // namespace rviz

namespace tsg::rviz_plugin {

/// Moves rviz's view so that all that is shown of the map is in it, from where it looks; and goes
/// on doing so while the map grows, until somebody moves the view. Knows rviz's views Orbit (and
/// its kin) and TopDownOrtho. Of the GUI's thread.
class ViewFitter : public QObject {
  Q_OBJECT
 public:
  explicit ViewFitter(rviz::DisplayContext& context, QObject* parent = nullptr);

  bool isFollowing() const { return timer_.isActive(); }
  void setFollowing(bool is_following);
  /// False if there is nothing to be seen, or the view is none that it knows.
  bool fit();

 Q_SIGNALS:
  /// Somebody else has moved the view, or setFollowing() was called.
  void followingChanged(bool is_following);

 private:
  /// Where the map has grown; somebody else who moved the view ends it.
  void fitAgain();
  bool fitOrbit(rviz::ViewController& view, const Eigen::AlignedBox3d& box) const;
  bool fitTopDown(rviz::ViewController& view, const Eigen::AlignedBox3d& box) const;

  rviz::DisplayContext& context_;
  QTimer timer_;
  Eigen::AlignedBox3d fitted_;   ///< what the view was last fitted to; empty: it was not
  std::vector<QVariant> state_;  ///< of the view since then
};

}  // namespace tsg::rviz_plugin

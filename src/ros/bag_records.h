// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace tsg::ros_interface {

/// Looks whether the lengths within a bag's records, its index and its chunks stay within these:
/// rosbag trusts all of them, and reads memory that is not the bag's where one is damaged
/// (http://wiki.ros.org/Bags/Format/2.0). To be called before rosbag opens it. Of a bag that was
/// not closed, which rosbag refuses by itself, only the first record is looked at.
///
/// Of compressed chunks only the index is looked at; their content has checksums of its own.
/// O(messages) small reads.
/// @throws std::runtime_error naming the byte of the file and what is wrong there
void checkBagRecords(const std::string& path);

}  // namespace tsg::ros_interface

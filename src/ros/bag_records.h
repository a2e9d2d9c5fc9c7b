// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace tsg::ros_interface {

/// Looks whether a bag's index and the lengths within its chunks stay within the chunks: rosbag
/// trusts both, and reads memory that is not a message's where one of them is damaged
/// (http://wiki.ros.org/Bags/Format/2.0).
///
/// Of compressed chunks only the index is looked at; their content has checksums of its own.
/// O(messages) small reads.
/// @throws std::runtime_error naming the byte of the file and what is wrong there
void checkBagRecords(const std::string& path);

}  // namespace tsg::ros_interface

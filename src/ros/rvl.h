// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

namespace tsg::ros_interface {

/// Decodes a 16-bit depth image: columns and rows (uint32 each, little-endian), then run lengths of
/// zeros and differences between successive values in nibbles of three bits and a flag. A. D.
/// Wilson, "Fast Lossless Depth Image Compression", ISS 2017. Empty if the data are cut short or no
/// image is so large (2^26 pixels). O(pixels).
cv::Mat decodeRvl(const std::uint8_t* data, std::size_t size);

}  // namespace tsg::ros_interface

#pragma once
#include <opencv2/core.hpp>

#include <string>

namespace talus::io
{
/** The bytes of a PNG: of 8 bits and one, three (BGR) or four channels (BGRA), or of 16 bits and
 * one. Empty for any other picture. */
std::string png_of(const cv::Mat& picture);

}  // namespace talus::io

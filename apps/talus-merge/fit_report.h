#pragma once
#include <talus/align/align.h>
#include <talus/site/merge.h>

#include <string>
#include <vector>

namespace talus::site
{
/** A line of how far two maps agree, by the names of their files. */
std::string text_of_fit(const MapFit& fit, const std::vector<std::string>& paths);

/** What is wrong with the two and what to do; empty where they fit. */
std::string warning_of_fit(
    const MapFit& fit, const std::vector<std::string>& paths, bool is_aligned);

/** Whether more disagrees of two maps than drives of one frame leave: something has changed, or
 * one lies aside along what hides most of it, as along walls. */
bool is_doubtful(const MapFit& fit);

/** Of two that fit better when the second is moved; empty where they do not. */
std::string warning_of_alignment(
    const MapFit& fit, const std::vector<std::string>& paths, const align::Alignment& alignment);

/** A line of how a map was moved. */
std::string text_of_alignment(const align::Alignment& alignment, const std::string& path);

}  // namespace talus::site

#include "tagcal/scene/rig_pairing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

void check_cameras(const std::vector<RigCamera>& cameras) {
  if (cameras.empty()) throw Error("rig: has no cameras");
}

Instant instant_of(std::size_t num_cameras) {
  return {std::vector<std::optional<std::size_t>>(num_cameras)};
}

// ---- Names

enum class Letters { digits, word, other };

Letters kind_of_letter(char c) {
  if (c >= '0' && c <= '9') return Letters::digits;
  const bool is_word = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c & 0x80) != 0;
  return is_word ? Letters::word : Letters::other;
}

// A name as its numbers, words and what is between them.
using NameParts = std::vector<std::string>;

NameParts parts_of(std::string_view name) {
  NameParts parts;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool goes_on = i > 0 && kind_of_letter(name[i - 1]) == kind_of_letter(name[i]);
    if (!goes_on) parts.emplace_back();
    parts.back() += name[i];
  }
  return parts;
}

// Without folder and ending.
std::string_view stem(std::string_view image) {
  image.remove_prefix(image.find_last_of('/') + 1);  // npos + 1 is 0
  const std::size_t dot = image.find_last_of('.');
  return dot == 0 || dot == image.npos ? image : image.substr(0, dot);
}

std::string_view without_zeros(std::string_view digits) {
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

// Numbers by their value; equal values by their text, so that the order is total.
struct ByNumbers {
  bool operator()(const NameParts& a, const NameParts& b) const {
    const std::size_t common = std::min(a.size(), b.size());
    for (std::size_t i = 0; i < common; ++i) {
      if (a[i] == b[i]) continue;
      if (kind_of_letter(a[i][0]) != Letters::digits || kind_of_letter(b[i][0]) != Letters::digits)
        return a[i] < b[i];
      const std::string_view x = without_zeros(a[i]), y = without_zeros(b[i]);
      if (x != y) return x.size() != y.size() ? x.size() < y.size() : x < y;
      return a[i] < b[i];
    }
    return a.size() < b.size();
  }
};

using NamesOfCameras = std::vector<std::vector<NameParts>>;  // by camera and view

NamesOfCameras names_of(const std::vector<RigCamera>& cameras) {
  NamesOfCameras names(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c)
    for (const View& view : cameras[c].data.views) names[c].push_back(parts_of(stem(view.image)));
  return names;
}

bool have_common_name(const NamesOfCameras& names) {
  std::set<NameParts> of_others;
  for (const auto& of_camera : names) {
    if (std::ranges::any_of(of_camera, [&](const auto& name) { return of_others.contains(name); }))
      return true;
    of_others.insert(of_camera.begin(), of_camera.end());
  }
  return names.size() < 2;
}

// The part at a place if it is the same in all names of each camera, and another one in each
// camera; empty otherwise.
std::vector<std::string> own_parts(const NamesOfCameras& names, std::size_t place) {
  std::vector<std::string> own;
  for (const auto& of_camera : names) {
    const std::string& part = of_camera.front()[place];
    if (kind_of_letter(part[0]) == Letters::other) return {};
    if (!std::ranges::all_of(of_camera, [&](const auto& name) { return name[place] == part; }))
      return {};
    if (std::ranges::find(own, part) != own.end()) return {};
    own.push_back(part);
  }
  return own;
}

bool are_names_of(const std::vector<std::string>& own, const std::vector<RigCamera>& cameras) {
  for (std::size_t c = 0; c < own.size(); ++c) {
    const NameParts name = parts_of(cameras[c].name);
    if (own[c] != cameras[c].name && std::ranges::find(name, own[c]) == name.end()) return false;
  }
  return true;
}

bool have_equal_form(const NamesOfCameras& names) {
  for (const auto& of_camera : names)
    for (const NameParts& name : of_camera)
      if (name.size() != names.front().front().size()) return false;
  return true;
}

std::string advice_on_names(const std::vector<RigCamera>& cameras, const NamesOfCameras& names) {
  std::vector<std::string> examples;
  for (std::size_t c = 0; c < names.size() && examples.size() < 2; ++c)
    if (!names[c].empty())
      examples.push_back(
          fmt::format("{} of camera {}", cameras[c].data.views[0].image, cameras[c].name));
  return fmt::format("names of pictures, such as {}; pair them by index, time or a file",
                     fmt::join(examples, " and "));
}

// The place of the part of the names that is the camera's own.
std::size_t place_of_own_part(const std::vector<RigCamera>& cameras, const NamesOfCameras& names) {
  std::vector<std::size_t> places, named;
  const bool all_seen = std::ranges::none_of(names, &std::vector<NameParts>::empty);
  if (all_seen && have_equal_form(names))
    for (std::size_t place = 0; place < names[0][0].size(); ++place) {
      const std::vector<std::string> own = own_parts(names, place);
      if (own.empty()) continue;
      places.push_back(place);
      if (are_names_of(own, cameras)) named.push_back(place);
    }
  if (named.size() == 1) return named[0];
  // One picture each: its number is as constant as the camera's.
  const bool is_evident = std::ranges::any_of(names, [](const auto& n) { return n.size() > 1; });
  if (places.size() == 1 && is_evident) return places[0];
  throw Error(fmt::format("rig: {} in the {}",
                          places.empty() ? "no two cameras have a name in common"
                                         : "it is not clear which part is the camera's own",
                          advice_on_names(cameras, names)));
}

// ---- Times

void check_times(const RigCamera& camera) {
  const auto fail = [&](std::size_t view, const std::string& message) {
    throw Error(fmt::format("camera {}: time of {}: {}", camera.name, camera.data.views[view].image,
                            message));
  };
  if (camera.times_s.size() != camera.data.views.size())
    throw Error(fmt::format("camera {}: has no times of its pictures, which pairing by time needs",
                            camera.name));
  for (std::size_t i = 0; i < camera.times_s.size(); ++i) {
    if (!std::isfinite(camera.times_s[i])) fail(i, "must be finite");
    if (i > 0 && camera.times_s[i] <= camera.times_s[i - 1])
      fail(i, fmt::format("must be after that of the picture before it, {} s, got {} s",
                          camera.times_s[i - 1], camera.times_s[i]));
  }
}

// The index of the nearest of sorted times, the earlier one of two; they are not empty.
std::size_t nearest(const std::vector<double>& times_s, double time_s) {
  const auto after = std::ranges::lower_bound(times_s, time_s);
  const auto i = static_cast<std::size_t>(after - times_s.begin());
  if (i == times_s.size()) return i - 1;
  return i > 0 && time_s - times_s[i - 1] <= times_s[i] - time_s ? i - 1 : i;
}

struct TimedInstant {
  double time_s = 0;  // of its first camera
  Instant instant;
};

// Adds the views of a camera to the instants, which are and stay in the order of time.
void add_by_time(std::vector<TimedInstant>& instants, const std::vector<RigCamera>& cameras,
                 std::size_t c, double tolerance_s) {
  const std::vector<double>& stamps_s = cameras[c].times_s;
  std::vector<double> times_s;
  for (const TimedInstant& timed : instants) times_s.push_back(timed.time_s);
  for (std::size_t view = 0; view < stamps_s.size(); ++view) {
    if (!times_s.empty()) {
      const std::size_t i = nearest(times_s, stamps_s[view]);
      const bool is_near = std::abs(times_s[i] - stamps_s[view]) <= tolerance_s;
      if (is_near && nearest(stamps_s, times_s[i]) == view) {
        instants[i].instant.view[c] = view;
        continue;
      }
    }
    instants.push_back({stamps_s[view], instant_of(cameras.size())});
    instants.back().instant.view[c] = view;
  }
  std::ranges::stable_sort(instants, {}, &TimedInstant::time_s);
}

}  // namespace

std::vector<Instant> pair_by_name(const std::vector<RigCamera>& cameras) {
  check_cameras(cameras);
  NamesOfCameras names = names_of(cameras);
  if (!have_common_name(names)) {
    const std::size_t place = place_of_own_part(cameras, names);
    for (auto& of_camera : names)
      for (NameParts& name : of_camera) name[place].clear();
    if (!have_common_name(names))
      throw Error("rig: no two cameras have a name in common in the " +
                  advice_on_names(cameras, names_of(cameras)));
  }
  std::map<NameParts, Instant, ByNumbers> instants;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    for (std::size_t view = 0; view < names[c].size(); ++view) {
      auto& slot =
          instants.try_emplace(names[c][view], instant_of(cameras.size())).first->second.view[c];
      if (slot)
        throw Error(
            fmt::format("camera {}: the pictures {} and {} have one name, which pairs them "
                        "with one instant: rename one",
                        cameras[c].name, cameras[c].data.views[*slot].image,
                        cameras[c].data.views[view].image));
      slot = view;
    }
  std::vector<Instant> result;
  for (auto& [name, instant] : instants) result.push_back(std::move(instant));
  return result;
}

std::vector<Instant> pair_by_index(const std::vector<RigCamera>& cameras) {
  check_cameras(cameras);
  const std::size_t count = cameras[0].data.views.size();
  for (const RigCamera& camera : cameras)
    if (camera.data.views.size() != count)
      throw Error(
          fmt::format("camera {}: has {} pictures, but camera {} has {}: pairing by index "
                      "needs equally many",
                      camera.name, camera.data.views.size(), cameras[0].name, count));
  std::vector<Instant> instants;
  for (std::size_t i = 0; i < count; ++i)
    instants.push_back({std::vector<std::optional<std::size_t>>(cameras.size(), i)});
  return instants;
}

std::vector<Instant> pair_by_time(const std::vector<RigCamera>& cameras, double tolerance_s) {
  check_cameras(cameras);
  if (!(tolerance_s >= 0) || !std::isfinite(tolerance_s))
    throw Error(fmt::format("rig: the tolerance of times must be >= 0, got {} s", tolerance_s));
  for (const RigCamera& camera : cameras) check_times(camera);
  std::vector<TimedInstant> timed;
  for (std::size_t c = 0; c < cameras.size(); ++c) add_by_time(timed, cameras, c, tolerance_s);
  std::vector<Instant> instants;
  for (TimedInstant& one : timed) instants.push_back(std::move(one.instant));
  return instants;
}

}  // namespace tagcal

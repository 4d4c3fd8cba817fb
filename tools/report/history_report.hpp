#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tagcal/estimate/fleet.hpp"

namespace tagcal::tools {

// The files of a history in the order given, with their keys.
struct HistoryInput {
  std::string key;  // its name: "order", "days" or that of --key
  std::vector<std::string> names;
  std::vector<double> keys;
  std::vector<UncertainCamera> cameras;
  std::vector<double> displacements_px;  // from the first, the largest in the image; NaN: not known
  std::vector<Eigen::Vector2d> samples;  // where all had corners
};

// Reads the cameras. Without a key the dates at the ends of all names count (cam7_2026-03-01, in
// days from the first), else the order. With a key it is a number in each file, or in the column of
// that name (or `value`) of the CSV file `values`, whose column `name` has the files' names, with
// or without folder and ending. Throws Error.
HistoryInput read_history(const std::vector<std::string>& files, const std::string& key,
                          const std::string& values);

// Estimates, with errors that name the file.
CameraHistory history_of(const HistoryInput& input);

std::string history_text(const CameraHistory& history, const HistoryInput& input);
nlohmann::ordered_json history_json(const CameraHistory& history, const HistoryInput& input);
std::string history_csv(const HistoryInput& input);  // a line a calibration

}  // namespace tagcal::tools

#include "tagcal/io/target_file.hpp"

#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_boards.hpp"

namespace tagcal {
using namespace internal;

Board read_target(const std::filesystem::path& file, std::optional<int> first_id,
                  std::vector<std::string>* warnings, std::optional<double> tag_size_m) {
  return board_from_yaml(YamlValue::read(file), first_id, warnings, tag_size_m);
}

std::string target_yaml(const Board& board) { return board_yaml(board); }

void write_target(const std::filesystem::path& file, const Board& board) {
  write_whole(file, target_yaml(board));
}

}  // namespace tagcal

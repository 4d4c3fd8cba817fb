#pragma once

#include <filesystem>
#include <vector>

// Checks of the files that a command is going to write, before any work. An empty path is no file;
// devices and pipes are never in the way.
namespace tagcal::tools {

// Throws Error if a file certainly cannot be written: there is a folder of that name, or no folder
// to contain it.
void check_writable(const std::filesystem::path& file);

// The same for a text. It must not have a picture's name either, as the first of several pictures
// has behind an option whose value was forgotten: `--out photos/*.png`.
void check_text_writable(const std::filesystem::path& file);

// The same for an answer in YAML. It must not have the name of another kind of text, which would be
// taken for that, or be replaced.
void check_yaml_writable(const std::filesystem::path& file);

// The same for a drawing, which must end in .svg or .png.
void check_drawing_writable(const std::filesystem::path& file);

// Throws Error if two of the outputs are one file, or if one of them is an input.
void check_replaces_nothing(const std::vector<std::filesystem::path>& outputs,
                            const std::vector<std::filesystem::path>& inputs);

// Throws Error if one of the files, relative to a folder, exists, unless `force`; with it, too, if
// it is one of the inputs.
void check_new_files(const std::filesystem::path& folder,
                     const std::vector<std::filesystem::path>& files,
                     const std::vector<std::filesystem::path>& inputs, bool force);

}  // namespace tagcal::tools

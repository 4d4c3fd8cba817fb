#pragma once

#include <gtest/gtest.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <locale>
#include <string>

namespace tagcal {

// The locale de_DE.UTF-8 (1.5 is "1,5", and 12345 is "12.345" in C++ streams) for the whole
// program while an object lives. It is made in `folder`, so it need not be installed.
class GermanLocale {
 public:
  explicit GermanLocale(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const std::string made = (folder / "de_DE.UTF-8").string();
    const std::string line = "localedef -i de_DE -f UTF-8 " + made + " >/dev/null 2>&1";
    // An installed one will do where localedef is missing.
    if (std::system(line.c_str()) == 0) setenv("LOCPATH", folder.c_str(), 1);
    is_there_ = std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr;
    if (is_there_) std::locale::global(std::locale("de_DE.UTF-8"));
  }
  ~GermanLocale() {
    std::locale::global(std::locale::classic());
    std::setlocale(LC_ALL, "C");
    unsetenv("LOCPATH");
  }
  GermanLocale(const GermanLocale&) = delete;
  GermanLocale& operator=(const GermanLocale&) = delete;

  bool is_there() const { return is_there_; }

 private:
  bool is_there_ = false;
};

}  // namespace tagcal

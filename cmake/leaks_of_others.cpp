// Leaks of libraries that are not ours, for the leak sanitizer, which asks the program for them.

extern "C" {
const char* __lsan_default_suppressions();
const char* __lsan_default_options();
}

// fontconfig, which cairo asks for the letters of `tagcal board --out x.pdf`, keeps its tables
// until the process ends; glibc does so where setlocale follows LOCPATH (only the test of locales
// sets it).
const char* __lsan_default_suppressions() { return "leak:libfontconfig\nleak:__argz_add_sep\n"; }

const char* __lsan_default_options() { return "print_suppressions=0"; }

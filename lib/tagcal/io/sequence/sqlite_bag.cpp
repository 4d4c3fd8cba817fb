// rosbag2's SQLite files: the tables `topics` and `messages`, whose data may be compressed by zstd.
// https://github.com/ros2/rosbag2, rosbag2_storage_sqlite3
#include <fmt/format.h>
#include <sqlite3.h>

#include <map>

#include "tagcal/error.hpp"
#include "tagcal/io/image/loaded_library.hpp"
#include "tagcal/io/sequence/bag_bytes.hpp"
#include "tagcal/io/sequence/bag_file.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

using std::string_view_literals::operator""sv;

struct Sqlite {
  decltype(&::sqlite3_open_v2) open;
  decltype(&::sqlite3_close_v2) close;
  decltype(&::sqlite3_exec) exec;
  decltype(&::sqlite3_limit) limit;
  decltype(&::sqlite3_progress_handler) progress_handler;
  decltype(&::sqlite3_prepare_v2) prepare;
  decltype(&::sqlite3_step) step;
  decltype(&::sqlite3_finalize) finalize;
  decltype(&::sqlite3_bind_int64) bind_int64;
  decltype(&::sqlite3_column_int64) column_int64;
  decltype(&::sqlite3_column_bytes) column_bytes;
  decltype(&::sqlite3_column_blob) column_blob;
};

const Sqlite& sqlite() {
  static const Sqlite all = [] {
    const LoadedLibrary library("sqlite3", 0, "bags of ROS 2 (.db3)", "libsqlite3-0");
    Sqlite found{};
    library.find("sqlite3_open_v2", found.open);
    library.find("sqlite3_close_v2", found.close);
    library.find("sqlite3_exec", found.exec);
    library.find("sqlite3_limit", found.limit);
    library.find("sqlite3_progress_handler", found.progress_handler);
    library.find("sqlite3_prepare_v2", found.prepare);
    library.find("sqlite3_step", found.step);
    library.find("sqlite3_finalize", found.finalize);
    library.find("sqlite3_bind_int64", found.bind_int64);
    library.find("sqlite3_column_int64", found.column_int64);
    library.find("sqlite3_column_bytes", found.column_bytes);
    library.find("sqlite3_column_blob", found.column_blob);
    return found;
  }();
  return all;
}

struct CloseSqlite {
  void operator()(sqlite3* database) const { sqlite().close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite().finalize(statement); }
};

// A name as an URI has it.
std::string uri_of(const std::filesystem::path& file, const char* query) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    const bool is_plain = c == '/' || c == '.' || c == '-' || c == '_' || (c >= '0' && c <= '9') ||
                          (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    uri += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<std::uint8_t>(c));
  }
  return uri + query;
}

class SqliteBag : public BagFile {
 public:
  explicit SqliteBag(const std::filesystem::path& file) {
    file_size_ = BagDescriptor(file).bytes().size();
    // A log beside it is that of a recorder that was ended: its rows are the last ones.
    std::error_code unknown;
    std::filesystem::path log = file;
    log += "-wal";
    const bool has_log = std::filesystem::file_size(log, unknown) > 0 && !unknown;
    sqlite3* database = nullptr;
    const std::string uri = uri_of(file, has_log ? "?mode=ro" : "?mode=ro&immutable=1");
    const int error =
        sqlite().open(uri.c_str(), &database,
                      SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
    database_.reset(database);
    if (error != SQLITE_OK) throw Error("cannot be opened by SQLite");
    guard();
    check_tables();
    read_topics();
    read_messages();
  }

  std::string read(const BagMessage& message) override {
    steps_left_ = steps_;
    return plain(stored_message(message));
  }

 private:
  using Statement = std::unique_ptr<sqlite3_stmt, CloseSqlite>;

  // Tables may hide expressions without end: what is done is proportional to the file's length.
  void guard() {
    constexpr int kBetween = 1000;                // numeric: instructions between two calls
    constexpr std::uint64_t kSteps = 10'000'000;  // numeric: a tenth of a second
    steps_ = steps_left_ = (kSteps + 10 * file_size_) / kBetween;
    sqlite().progress_handler(database_.get(), kBetween, is_over, this);
    sqlite().limit(database_.get(), SQLITE_LIMIT_LENGTH,
                   static_cast<int>(limits::kMaxBagChunkBytes));
    sqlite().exec(database_.get(), "PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON;",
                  nullptr, nullptr, nullptr);
  }

  static int is_over(void* bag) {
    auto& left = static_cast<SqliteBag*>(bag)->steps_left_;
    return left == 0 || --left == 0 ? 1 : 0;
  }

  Statement prepared(const char* sql) {
    sqlite3_stmt* statement = nullptr;
    if (sqlite().prepare(database_.get(), sql, -1, &statement, nullptr) != SQLITE_OK)
      throw Error("is no bag of ROS 2: it has no tables of topics and messages, or is damaged");
    return Statement(statement);
  }

  // The next row. Damage ends the rows.
  bool next(Statement& statement) {
    const int result = sqlite().step(statement.get());
    if (result != SQLITE_ROW && result != SQLITE_DONE) is_cut_off_ = true;
    return result == SQLITE_ROW;
  }

  static std::string bytes_of(Statement& statement, int column) {
    const void* const bytes = sqlite().column_blob(statement.get(), column);
    const int size = sqlite().column_bytes(statement.get(), column);
    return bytes ? std::string(static_cast<const char*>(bytes), size) : std::string();
  }

  // Views and virtual tables in their place run code of the file.
  void check_tables() {
    Statement rows = prepared(
        "SELECT count(*) FROM sqlite_master WHERE name IN ('topics', 'messages') AND type = "
        "'table' AND sql LIKE 'CREATE TABLE%'");
    if (!next(rows) || sqlite().column_int64(rows.get(), 0) != 2)
      throw Error("is no bag of ROS 2: it has no tables of topics and messages, or is damaged");
  }

  void read_topics() {
    Statement rows = prepared("SELECT id, name, type, serialization_format FROM topics");
    while (next(rows)) {
      const bool is_cdr = bytes_of(rows, 3) == "cdr";
      const std::string type = bytes_of(rows, 2);
      by_id_[sqlite().column_int64(rows.get(), 0)] = add_topic(
          bytes_of(rows, 1), is_cdr ? type : type + " in " + bytes_of(rows, 3), RosCoding::cdr);
    }
  }

  void read_messages() {
    Statement rows = prepared(
        "SELECT rowid, topic_id, timestamp, length(data), substr(data, 1, 12) FROM messages");
    while (next(rows)) {
      const auto topic = by_id_.find(sqlite().column_int64(rows.get(), 1));
      if (topic == by_id_.end()) continue;
      BagMessage message{.topic = topic->second};
      message.at = static_cast<std::uint64_t>(sqlite().column_int64(rows.get(), 0));
      message.recorded_ns = sqlite().column_int64(rows.get(), 2);
      message.size = static_cast<std::uint64_t>(sqlite().column_int64(rows.get(), 3));
      add_message(message, beginning_of(message, bytes_of(rows, 4)));
    }
  }

  // The first bytes of a message's picture, which may have to be unpacked for them. Of damaged ones
  // none: the time of recording counts.
  std::string beginning_of(const BagMessage& message, const std::string& stored) {
    if (!is_packed(stored) || !is_ros_picture(topics_[message.topic].type)) return stored;
    const std::string packed = stored_message(message);
    allow_unpacking(stated_zstd_size(packed), file_size_);
    try {
      return plain(packed).substr(0, kStampBytes);
    } catch (const Error&) {
      return "";
    }
  }

  std::string stored_message(const BagMessage& message) {
    Statement row = prepared("SELECT data FROM messages WHERE rowid = ?");
    sqlite().bind_int64(row.get(), 1, static_cast<sqlite3_int64>(message.at));
    if (sqlite().step(row.get()) != SQLITE_ROW) throw Error("has a damaged picture");
    return bytes_of(row, 0);
  }

  static bool is_packed(std::string_view bytes) { return bytes.starts_with("\x28\xb5\x2f\xfd"sv); }

  static std::string plain(std::string bytes) {
    if (!is_packed(bytes)) return bytes;
    const std::uint64_t size = stated_zstd_size(bytes);
    if (size == 0 || size > limits::kMaxBagChunkBytes)
      throw Error(fmt::format("has a picture of {} bytes", size));
    try {
      return decompressed("zstd", bytes, size);
    } catch (const Damage&) {
      throw Error("has a damaged picture");
    }
  }

  std::unique_ptr<sqlite3, CloseSqlite> database_;
  std::uint64_t file_size_ = 0;
  std::uint64_t steps_ = 0, steps_left_ = 0;
  std::map<std::int64_t, std::size_t> by_id_;
};

}  // namespace

std::unique_ptr<BagFile> open_sqlite_bag(const std::filesystem::path& file) {
  return std::make_unique<SqliteBag>(file);
}

}  // namespace tagcal::internal

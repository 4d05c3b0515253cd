#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gpsrecon/core/vec.h>
#include <gpsrecon/report/report.h>

namespace gpsrecon::cli {

/// Options that every command has.
struct GlobalOptions {
  int threads = 0;
  std::uint64_t seed = 1;
  bool quiet = false;
  bool verbose = false;
  std::string log_file;
  std::string progress = "auto";
};

/// Thrown by Arguments::parse when --help or --version was answered and nothing is left to do.
struct Answered {};

/// The arguments of one command: declared, then parsed, then in the variables they were declared with. An option is
/// declared once, with its meaning, unit, range and default; --help is made of that. Hides the parser library.
class Arguments {
 public:
  /// `command` is empty for the chain. `words` are the arguments without program and command name.
  Arguments(std::string command, std::string summary, std::vector<std::string> words);
  ~Arguments();
  Arguments(const Arguments&) = delete;
  Arguments& operator=(const Arguments&) = delete;

  /// A required argument without a name. `meaning` is one sentence without a full stop, like all texts here.
  void positional(const std::string& name, std::string& value, const std::string& meaning);
  /// One or more of them.
  void positionals(const std::string& name, std::vector<std::string>& values, const std::string& meaning);

  /// Title of the options declared next in --help, and whether they are among values().
  void group(const std::string& title, bool in_values = true);
  /// `name` is spelled with its dashes. The variable's value at the time of the call is the default in --help. Ranges
  /// are for --help; it is the options structs that check them. Values of doubles must be finite.
  void option(const std::string& name, const std::string& value_name, double& value, const std::string& meaning,
              const std::string& range);
  void option(const std::string& name, const std::string& value_name, int& value, const std::string& meaning,
              const std::string& range);
  void option(const std::string& name, const std::string& value_name, std::size_t& value, const std::string& meaning,
              const std::string& range);
  /// A text, such as a file name. `default_text` says what happens without it.
  void option(const std::string& name, const std::string& value_name, std::string& value, const std::string& meaning,
              const std::string& range, const std::string& default_text);
  /// Any other type: `read` takes the text and throws OptionError saying what was expected. Without `value` the text is
  /// what values() holds.
  void option(const std::string& name, const std::string& value_name, const std::string& meaning,
              const std::string& range, const std::string& default_text, std::function<void(const std::string&)> read,
              std::function<OptionValue()> value = nullptr);
  /// One of several words, each standing for a value.
  template <class T>
  void choice(const std::string& name, T& value, const std::vector<std::pair<std::string, T>>& words,
              const std::string& meaning) {
    std::string names, default_text;
    for (const auto& [word, meant] : words) {
      names += (names.empty() ? "" : "|") + word;
      if (meant == value) default_text = word;
    }
    option(name, names, meaning, "", default_text, [&value, words, names](const std::string& text) {
      for (const auto& [word, meant] : words)
        if (word == text) return static_cast<void>(value = meant);
      throw_unexpected(text, "one of " + names);
    });
  }
  /// An option that may be given any number of times, for commands in which the order of such options counts: `read`
  /// is called for each, in the order of the command line. Not for configuration files, and not among values().
  void sequence(const std::string& name, const std::string& value_name, const std::string& meaning,
                const std::string& range, const std::string& default_text,
                std::function<void(const std::string&)> read);
  /// An option without a value, by default off.
  void flag(const std::string& name, bool& value, const std::string& meaning);
  void flag(const std::string& name, const std::string& meaning, std::function<void()> when_given);

  /// Parses. Throws OptionError for what does not fit the declarations, Answered after --help and --version.
  GlobalOptions parse();

  /// The values in force after parse(), by option name without dashes, of the groups that are `in_values`.
  std::map<std::string, OptionValue> values() const;

  /// Everything that was declared, as --help shows it.
  std::string help() const;

  /// Number of leading words that are global options and their values.
  static std::size_t count_global_words(std::span<const std::string> words);

 private:
  [[noreturn]] static void throw_unexpected(const std::string& text, const std::string& expected);
  void declare_globals(GlobalOptions& options);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Numbers as the command line and the configuration file spell them: decimal, point as separator, nothing after them.
/// Throw OptionError saying what was expected instead of `text`.
double parse_double(const std::string& text);
std::int64_t parse_integer(const std::string& text);
std::uint64_t parse_natural(const std::string& text);
Vec3 parse_point(const std::string& text);

}  // namespace gpsrecon::cli

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gpsrecon/core/options.h>

namespace gpsrecon::cli {

enum class Progress { automatic, always, never };
constexpr std::array<std::string_view, 3> option_names(Progress /*type*/) {
  return {"auto", "always", "never"};
}

/// Options that every command has.
struct GlobalOptions {
  int threads = 0;
  std::size_t seed = 1;
  std::string config, log_file;
  bool quiet = false;
  bool verbose = false;
  Progress progress = Progress::automatic;

  static OptionTable fields() {
    using O = GlobalOptions;
    return {
        field<&O::threads>("threads", "[0, 1024]",
                           "number of threads, 0 = OMP_NUM_THREADS or all of the machine; results do not depend on it"),
        field<&O::seed>("seed", ">= 0", "seed of everything random, below 2^64"),
        field<&O::config>("config", "",
                          "file with lines 'option = value' (TOML or INI, names without the dashes, an option that "
                          "takes no value is set to true); the command line has precedence"),
        field<&O::quiet>("quiet", "", "tell nothing but warnings and errors"),
        field<&O::verbose>("verbose", "", "tell details"),
        field<&O::log_file>("log-file", "",
                            "write all messages, details included, to FILE as well; it is kept whatever happens"),
        field<&O::progress>("progress", "", "progress bar on standard error; auto shows it on a terminal only")};
  }
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
  /// One row of a table, see below.
  void field(const Field& row, void* options);
  /// The options of a table: NAME VALUE, switches --NAME, or --no-NAME where the value at the time of the call is true.
  /// That value is the default in --help. Those only for code and those in `except` are left out.
  template <class Options>
  void fields(Options& options, std::initializer_list<std::string_view> except = {}) {
    for (const Field& row : Options::fields())
      if (std::find(except.begin(), except.end(), row.name) == except.end()) field(row, &options);
  }
  /// Only those.
  template <class Options>
  void only_fields(Options& options, std::initializer_list<std::string_view> names) {
    for (const Field& row : Options::fields())
      if (std::find(names.begin(), names.end(), row.name) != names.end()) field(row, &options);
  }
  /// What is not simply a value: `read` takes the text and throws OptionError saying what was expected. `name` is
  /// spelled with its dashes. Without `value` the text is what values() holds.
  void option(const std::string& name, const std::string& value_name, const std::string& meaning,
              const std::string& range, const std::string& default_text, std::function<void(const std::string&)> read,
              std::function<OptionValue()> value = nullptr);
  /// An option that may be given any number of times, for commands in which the order of such options counts: `read`
  /// is called for each, in the order of the command line. Not for configuration files, and not among values().
  void sequence(const std::string& name, const std::string& value_name, const std::string& meaning,
                const std::string& range, const std::string& default_text,
                std::function<void(const std::string&)> read);
  /// An option without a value.
  void flag(const std::string& name, const std::string& meaning, std::function<void()> when_given);

  /// Parses. Throws OptionError for what does not fit the declarations, Answered after --help and --version.
  GlobalOptions parse();

  /// The values in force after parse(), by option name without dashes, of the groups that are `in_values`.
  std::map<std::string, OptionValue> values() const;

  /// Everything that was declared, as --help shows it.
  std::string help() const;
  /// The options as tables of the manual, group by group, as --help-markdown shows them.
  std::string markdown() const;

  /// Where the name of a command stands, if there is one: after options of every command and their values. (Words of
  /// the chain may be names of commands elsewhere, which CLI11's own subcommands would not tell apart; and they would
  /// pass on what they do not know to the chain.)
  static std::size_t position_of_command(const std::vector<std::string>& words);

 private:
  void declare_globals(GlobalOptions& options);
  void refuse_former_spellings();

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gpsrecon::cli

#include "arguments.h"

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/version.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>

namespace gpsrecon::cli {
namespace {

std::string in_quotes(const std::string& text) {
  return "'" + text + "'";
}

[[noreturn]] void expected(const std::string& what, const std::string& text) {
  throw OptionError("expected " + what + ", got " + in_quotes(text));
}

/// The shortest text that is read back as the same number.
template <class T>
std::string shortest(T value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

template <class T>
bool read_whole(const std::string& text, T& value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (text.size() > 1 && *begin == '+' && text[1] != '-') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc{} && stop == end;
}

/// `text` broken into lines of at most `width` characters, each but the first indented.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::istringstream words(text);
  std::string word, result;
  std::size_t column = indent;
  while (words >> word) {
    if (column > indent && column + 1 + word.size() > width) {
      result += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      result += ' ';
      ++column;
    }
    result += word;
    column += word.size();
  }
  return result;
}

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

struct ConfigValue {
  std::string place;  ///< file and line, for messages
  std::string text;
};

/// The value right of the equals sign: a quoted string, a list in brackets, or a word; a comment may follow.
std::string config_value(const std::string& text, const std::string& place) {
  const auto rest_is_empty = [](const std::string& rest) { return trimmed(rest).empty() || trimmed(rest)[0] == '#'; };
  if (!text.empty() && (text[0] == '"' || text[0] == '\'' || text[0] == '[')) {
    const auto end = text.find(text[0] == '[' ? ']' : text[0], 1);
    if (end == std::string::npos || !rest_is_empty(text.substr(end + 1)))
      throw OptionError(place + ": expected a closing quote or bracket at the end, got " + in_quotes(text));
    std::string value = text.substr(1, end - 1);
    if (text[0] == '[') std::erase(value, ' ');
    return value;
  }
  return trimmed(text.substr(0, text.find('#')));
}

/// Values of a configuration file by option name: the subset of TOML and INI that has no sections.
std::map<std::string, ConfigValue> read_config(const std::string& path) {
  std::ifstream file(path);
  std::map<std::string, ConfigValue> values;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::string place = path + ":" + std::to_string(number);
    line = trimmed(line);
    if (line.empty() || line[0] == '#' || line[0] == ';') continue;
    const auto equals = line.find('=');
    if (line[0] == '[' || equals == std::string::npos)
      throw OptionError(place + ": expected 'option = value', got " + in_quotes(line));
    const std::string name = trimmed(line.substr(0, equals));
    if (!values.emplace(name, ConfigValue{place, config_value(trimmed(line.substr(equals + 1)), place)}).second)
      throw OptionError(place + ": " + name + " is given twice");
  }
  if (!file.eof()) throw OptionError(path + ": configuration file cannot be read");
  return values;
}

bool parse_switch(const std::string& text) {
  if (text == "true" || text == "on" || text == "yes" || text == "1") return true;
  if (text == "false" || text == "off" || text == "no" || text == "0") return false;
  expected("true or false", text);
}

}  // namespace

double parse_double(const std::string& text) {
  double value = 0;
  if (!read_whole(text, value) || !std::isfinite(value)) expected("a number", text);
  return value;
}

std::int64_t parse_integer(const std::string& text) {
  std::int64_t value = 0;
  if (!read_whole(text, value)) expected("an integer", text);
  return value;
}

std::uint64_t parse_natural(const std::string& text) {
  std::uint64_t value = 0;
  if (!read_whole(text, value)) expected("an integer >= 0", text);
  return value;
}

Vec3 parse_point(const std::string& text) {
  Vec3 point;
  std::istringstream fields(text);
  std::string field;
  int count = 0;
  while (std::getline(fields, field, ',')) {
    if (count == 3 || !read_whole(field, point[count]) || !std::isfinite(point[count]))
      expected("three numbers X,Y,Z", text);
    ++count;
  }
  if (count != 3 || text.back() == ',') expected("three numbers X,Y,Z", text);
  return point;
}

struct Arguments::Impl {
  struct Positional {
    std::string name, meaning;
    bool many;
  };
  struct Option {
    std::string group, name, value_name, description;
    CLI::Option* parsed;
    std::function<void(const std::string&)> read;
    std::function<OptionValue()> value;
    std::string text;  ///< as given, or what --help calls the default
    bool in_values;
    bool configurable = true;
    bool repeatable = false;

    void apply(const std::string& given) {
      read(given);
      text = given;
    }

    bool takes_value() const { return !value_name.empty(); }
  };

  std::string command, summary;
  std::vector<std::string> words;
  CLI::App app;
  std::vector<Positional> positionals;
  std::vector<Option> options;
  std::string current_group = "Options";
  bool group_in_values = true;
  std::string config;

  void apply_values();
  void apply_sequences();
};

Arguments::Arguments(std::string command, std::string summary, std::vector<std::string> words)
    : impl_(std::make_unique<Impl>()) {
  impl_->command = std::move(command);
  impl_->summary = std::move(summary);
  impl_->words = std::move(words);
  impl_->app.set_help_flag();
}

Arguments::~Arguments() = default;

void Arguments::positional(const std::string& name, std::string& value, const std::string& meaning) {
  impl_->app.add_option(name, value)->required();
  impl_->positionals.push_back({name, meaning, false});
}

void Arguments::positionals(const std::string& name, std::vector<std::string>& values, const std::string& meaning) {
  impl_->app.add_option(name, values)->required();
  impl_->positionals.push_back({name, meaning, true});
}

void Arguments::group(const std::string& title, bool in_values) {
  impl_->current_group = title;
  impl_->group_in_values = in_values;
}

void Arguments::option(const std::string& name, const std::string& value_name, const std::string& meaning,
                       const std::string& range, const std::string& default_text,
                       std::function<void(const std::string&)> read, std::function<OptionValue()> value) {
  std::string description = meaning;
  if (!range.empty()) description += "; range: " + range;
  if (!default_text.empty()) description += "; default: " + default_text;
  impl_->options.push_back({.group = impl_->current_group,
                            .name = name,
                            .value_name = value_name,
                            .description = description,
                            .parsed = impl_->app.add_option(name)->expected(1)->type_size(1),
                            .read = std::move(read),
                            .value = std::move(value),
                            .text = default_text,
                            .in_values = impl_->group_in_values});
}

void Arguments::option(const std::string& name, const std::string& value_name, double& value,
                       const std::string& meaning, const std::string& range) {
  option(
      name, value_name, meaning, range, shortest(value),
      [&value](const std::string& text) { value = parse_double(text); }, [&value] { return OptionValue(value); });
}

void Arguments::option(const std::string& name, const std::string& value_name, int& value, const std::string& meaning,
                       const std::string& range) {
  const auto read = [&value](const std::string& text) {
    const std::int64_t parsed = parse_integer(text);
    value = static_cast<int>(parsed);
    if (value != parsed) expected("a smaller integer", text);
  };
  option(name, value_name, meaning, range, shortest(value), read,
         [&value] { return OptionValue(std::int64_t{value}); });
}

void Arguments::option(const std::string& name, const std::string& value_name, std::size_t& value,
                       const std::string& meaning, const std::string& range) {
  option(
      name, value_name, meaning, range, shortest(value),
      [&value](const std::string& text) { value = parse_natural(text); },
      [&value] { return OptionValue(static_cast<std::int64_t>(value)); });
}

void Arguments::option(const std::string& name, const std::string& value_name, std::string& value,
                       const std::string& meaning, const std::string& range, const std::string& default_text) {
  option(name, value_name, meaning, range, default_text, [&value](const std::string& text) {
    if (text.empty()) expected("a text that is not empty", text);
    value = text;
  });
}

void Arguments::sequence(const std::string& name, const std::string& value_name, const std::string& meaning,
                         const std::string& range, const std::string& default_text,
                         std::function<void(const std::string&)> read) {
  option(name, value_name, meaning, range, default_text, std::move(read));
  Impl::Option& declared = impl_->options.back();
  declared.parsed->expected(1, std::numeric_limits<int>::max())->allow_extra_args(false);
  declared.in_values = false;
  declared.configurable = false;
  declared.repeatable = true;
}

void Arguments::flag(const std::string& name, const std::string& meaning, std::function<void()> when_given) {
  impl_->options.push_back({.group = impl_->current_group,
                            .name = name,
                            .value_name = "",
                            .description = meaning,
                            .parsed = impl_->app.add_flag(name),
                            .read =
                                [act = std::move(when_given)](const std::string& text) {
                                  if (parse_switch(text)) act();
                                },
                            .value = nullptr,
                            .text = "",
                            .in_values = false});
}

void Arguments::flag(const std::string& name, bool& value, const std::string& meaning) {
  flag(name, meaning, [&value] { value = true; });
  impl_->options.back().value = [&value] { return OptionValue(value); };
  impl_->options.back().in_values = impl_->group_in_values;
}

void Arguments::throw_unexpected(const std::string& text, const std::string& what) {
  expected(what, text);
}

void Arguments::declare_globals(GlobalOptions& options) {
  group("Options of every command", false);
  option("--threads", "N", options.threads,
         "number of threads, 0 = OMP_NUM_THREADS or all of the machine; results do not depend on it", "[0, 1024]");
  option("--seed", "N", options.seed, "seed of everything random", "[0, 2^64)");
  option(
      "--config", "FILE", impl_->config,
      "file with lines 'option = value' (TOML or INI, names without the dashes, an option that takes no value is set "
      "to true); the command line has precedence",
      "", "none");
  impl_->options.back().configurable = false;
  flag("--quiet", options.quiet, "tell nothing but warnings and errors");
  flag("--verbose", options.verbose, "tell details");
  option("--log-file", "FILE", options.log_file, "write all messages, details included, to FILE as well", "", "none");
  choice<std::string>("--progress", options.progress, {{"auto", "auto"}, {"always", "always"}, {"never", "never"}},
                      "progress bar on standard error; auto shows it on a terminal only");
}

/// The command line has precedence over the configuration file.
void Arguments::Impl::apply_values() {
  const auto find = [this](const std::string& name) -> const Option& {
    return *std::find_if(options.begin(), options.end(), [&](const Option& o) { return o.name == name; });
  };
  std::map<std::string, ConfigValue> from_file;
  if (const CLI::Option* given = find("--config").parsed; given->count() > 0)
    from_file = read_config(given->results().back());
  for (Option& option : options) {
    if (option.repeatable) continue;
    const bool on_line = option.parsed->count() > 0;
    const auto in_file = from_file.find(option.name.substr(2));
    const bool from_config = in_file != from_file.end() && option.configurable;
    try {
      if (on_line)
        option.apply(option.takes_value() ? option.parsed->results().back() : "true");
      else if (from_config)
        option.apply(in_file->second.text);
    } catch (const OptionError& error) {
      throw OptionError((on_line ? option.name : in_file->second.place + ": " + in_file->first) + ": " + error.what());
    }
    if (from_config) from_file.erase(in_file);
  }
  apply_sequences();
  for (const auto& [name, value] : from_file) throw OptionError(value.place + ": unknown option " + in_quotes(name));
}

/// The options of sequence(), each time it was given, in the order of the command line.
void Arguments::Impl::apply_sequences() {
  std::map<const CLI::Option*, std::size_t> used;
  for (const CLI::Option* parsed : app.parse_order()) {
    const auto option = std::find_if(options.begin(), options.end(),
                                     [&](const Option& o) { return o.parsed == parsed && o.repeatable; });
    if (option == options.end()) continue;
    try {
      option->read(parsed->results().at(used[parsed]++));
    } catch (const OptionError& error) {
      throw OptionError(option->name + ": " + error.what());
    }
  }
}

GlobalOptions Arguments::parse() {
  GlobalOptions globals;
  declare_globals(globals);
  bool help_wanted = false, version_wanted = false;
  flag("--version", version_wanted, "print the version and exit");
  impl_->options.back().configurable = false;
  flag("--help", help_wanted, "print this text and exit");
  impl_->options.back().configurable = false;
  // Asked for help, the program helps, whatever else is wrong or missing.
  for (const std::string& word : impl_->words) {
    if (word == "--") break;
    if (word == "--help" || word == "-h") {
      std::cout << help();
      throw Answered{};
    }
    if (word == "--version") {
      std::cout << "gpsrecon " << version << "\n";
      throw Answered{};
    }
  }
  try {
    impl_->app.parse(std::vector<std::string>(impl_->words.rbegin(), impl_->words.rend()));
  } catch (const CLI::ExtrasError& error) {
    throw OptionError(std::string("unknown option or too many arguments: ") +
                      std::string(error.what()).substr(std::string(error.what()).find(": ") + 2));
  } catch (const CLI::Error& error) {
    throw OptionError(error.what());
  }
  impl_->apply_values();
  if (globals.threads < 0 || globals.threads > 1024)
    throw OptionError("--threads: expected an integer in [0, 1024], got " + in_quotes(std::to_string(globals.threads)));
  return globals;
}

std::map<std::string, OptionValue> Arguments::values() const {
  std::map<std::string, OptionValue> values;
  for (const auto& option : impl_->options)
    if (option.in_values) values[option.name.substr(2)] = option.value ? option.value() : OptionValue(option.text);
  return values;
}

std::string Arguments::help() const {
  constexpr std::size_t width = 100, indent = 30;
  std::string text = "Usage: gpsrecon " + impl_->command + (impl_->command.empty() ? "" : " ");
  for (const auto& p : impl_->positionals) text += p.name + (p.many ? "... " : " ");
  text += "[options]\n\n" + wrapped(impl_->summary, 0, width) + "\n";
  const auto entry = [&](const std::string& head, const std::string& body) {
    std::string line = "  " + head;
    if (line.size() + 2 > indent)
      line += "\n" + std::string(indent, ' ');
    else
      line.resize(indent, ' ');
    return line + wrapped(body, indent, width) + "\n";
  };
  text += "\nArguments:\n";
  for (const auto& p : impl_->positionals) text += entry(p.name, p.meaning);
  std::string group;
  for (const auto& o : impl_->options) {
    if (o.group != group) text += "\n" + (group = o.group) + ":\n";
    text += entry(o.name + (o.takes_value() ? " " + o.value_name : ""), o.description);
  }
  return text;
}

std::size_t Arguments::count_global_words(std::span<const std::string> words) {
  Arguments arguments("", "", {});
  GlobalOptions globals;
  arguments.declare_globals(globals);
  std::size_t count = 0;
  while (count < words.size()) {
    const std::string name = words[count].substr(0, words[count].find('='));
    const auto& options = arguments.impl_->options;
    const auto option = std::find_if(options.begin(), options.end(), [&](const auto& o) { return o.name == name; });
    if (option == options.end()) break;
    count += option->takes_value() && name == words[count] ? 2 : 1;
  }
  return std::min(count, words.size());
}

}  // namespace gpsrecon::cli

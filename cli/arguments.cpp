#include "arguments.h"

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/numbers.h>
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

using namespace internal;
namespace {

std::string in_quotes(const std::string& text) {
  return "'" + text + "'";
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

/// Values of a configuration file by option name: the subset of TOML and INI that has no sections. CLI11 reads such
/// files too, but forgets the lines, which messages name, and applies their values in the order of the file and before
/// those of the command line; here an option that presets others, such as --quality of `scan`, comes first wherever it
/// stands.
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

/// How lengths were spelled that were a share of the diagonal before they said so in their text.
constexpr std::array<std::pair<const char*, const char*>, 8> former_spellings{
    {{"--sigma0-rel", "--sigma0"},
     {"--tolerance-rel", "--tolerance"},
     {"--h-rel", "--support-radius"},
     {"--noise-rel", "--noise"},
     {"--bias-rel", "--bias"},
     {"--registration-rel", "--registration"},
     {"--spike-rel", "--spike-length"},
     {"--truth-tolerance-rel", "--truth-tolerance"}}};

std::string length_of_share(const std::string& text) {
  const double share = parse_double(text);
  return share == 0 ? "auto" : Length::of_diagonal(share).text();
}

}  // namespace

struct Arguments::Impl {
  struct Positional {
    std::string name, meaning;
    bool many;
  };
  struct Option {
    std::string group, name, value_name, meaning, range, default_text;
    CLI::Option* parsed;
    std::function<void(const std::string&)> read;
    std::function<OptionValue()> value;
    std::string key;   ///< in values()
    std::string text;  ///< as given, or what --help calls the default
    bool in_values;
    bool configurable = true;
    bool repeatable = false;

    void apply(const std::string& given) {
      read(given);
      text = given;
    }

    bool takes_value() const { return !value_name.empty(); }
    std::string description() const {
      return meaning + (range.empty() ? "" : "; range: " + range) +
             (default_text.empty() ? "" : "; default: " + default_text);
    }
  };

  std::string command, summary;
  std::vector<std::string> words;
  CLI::App app;
  std::vector<Positional> positionals;
  std::vector<Option> options;
  std::string current_group = "Options";
  bool group_in_values = true;

  bool knows(const std::string& name) const {
    return std::any_of(options.begin(), options.end(), [&](const Option& o) { return o.name == name; });
  }
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
  impl_->options.push_back({.group = impl_->current_group,
                            .name = name,
                            .value_name = value_name,
                            .meaning = meaning,
                            .range = range,
                            .default_text = default_text,
                            .parsed = impl_->app.add_option(name)->expected(1)->type_size(1),
                            .read = std::move(read),
                            .value = std::move(value),
                            .key = name.substr(2),
                            .text = default_text,
                            .in_values = impl_->group_in_values});
}

void Arguments::field(const Field& row, void* options) {
  if (row.in_library) return;
  const OptionState now = row.state(options);
  const auto value = [row, options] { return row.state(options).value; };
  if (row.is_switch) {
    const bool takes_away = now.text == "true";
    flag("--" + std::string(takes_away ? "no-" : "") + std::string(row.name),
         (takes_away ? "do not " : "") + std::string(row.meaning),
         [row, options, takes_away] { row.set(options, takes_away ? "false" : "true"); });
    impl_->options.back().value = value;
    impl_->options.back().in_values = impl_->group_in_values;
  } else {
    option(
        "--" + std::string(row.name), row.placeholder, std::string(row.meaning),
        std::string(row.range) + (row.unit.empty() ? "" : " " + std::string(row.unit)), now.text,
        [row, options](const std::string& text) { row.set(options, text); }, value);
  }
  impl_->options.back().key = row.name;
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
                            .meaning = meaning,
                            .range = "",
                            .default_text = "",
                            .parsed = impl_->app.add_flag(name),
                            .read =
                                [act = std::move(when_given)](const std::string& text) {
                                  if (OptionType<bool>::read(text)) act();
                                },
                            .value = nullptr,
                            .key = name.substr(2),
                            .text = "",
                            .in_values = false});
}

void Arguments::declare_globals(GlobalOptions& options) {
  group("Options of every command", false);
  fields(options);
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

void Arguments::refuse_former_spellings() {
  group("", false);  // not in the help
  for (const auto& [former, now] : former_spellings) {
    if (!impl_->knows(now)) continue;
    option(former, "X", "", "", "", [now = now](const std::string& text) {
      throw OptionError("is now spelled " + std::string(now) + " " + length_of_share(text));
    });
  }
}

GlobalOptions Arguments::parse() {
  GlobalOptions globals;
  declare_globals(globals);
  for (Impl::Option& option : impl_->options) option.configurable = option.configurable && option.name != "--config";
  flag("--version", "print the version and exit", [] {});
  impl_->options.back().configurable = false;
  flag("--help", "print this text and exit", [] {});
  impl_->options.back().configurable = false;
  refuse_former_spellings();
  // Asked for help, the program helps, whatever else is wrong or missing. (CLI11 looks at the values first.)
  for (const std::string& word : impl_->words) {
    if (word == "--") break;
    if (word == "--help" || word == "-h") {
      std::cout << help();
      throw Answered{};
    }
    if (word == "--help-markdown") {  // for scripts/option_tables.py
      std::cout << markdown();
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
  check_fields(globals);
  return globals;
}

std::map<std::string, OptionValue> Arguments::values() const {
  std::map<std::string, OptionValue> values;
  for (const auto& option : impl_->options)
    if (option.in_values) values[option.key] = option.value ? option.value() : OptionValue(option.text);
  return values;
}

/// CLI11's own help has neither ranges nor lines of a bounded width.
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
    if (o.group.empty()) continue;
    if (o.group != group) text += "\n" + (group = o.group) + ":\n";
    text += entry(o.name + (o.takes_value() ? " " + o.value_name : ""), o.description());
  }
  return text;
}

std::string Arguments::markdown() const {
  const auto cell = [](const std::string& text) {
    std::string escaped;
    for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
    return " " + escaped + (text.empty() ? "|" : " |");
  };
  std::string text, group;
  for (const auto& o : impl_->options) {
    if (o.group.empty()) continue;
    if (o.group != group)
      text += "## " + (group = o.group) + "\n| option | range | default | meaning |\n|---|---|---|---|\n";
    text += "|" + cell("`" + o.name + (o.takes_value() ? " " + o.value_name : "") + "`") + cell(o.range) +
            cell(o.takes_value() ? o.default_text : "off") + cell(o.meaning) + "\n";
  }
  return text;
}

std::size_t Arguments::position_of_command(const std::vector<std::string>& words) {
  CLI::App app;
  app.prefix_command()->set_help_flag();
  for (const Field& row : GlobalOptions::fields()) {
    const std::string name = "--" + std::string(row.name);
    row.is_switch ? app.add_flag(name) : app.add_option(name);
  }
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::Error&) {
    return words.size();  // a global option without its value: told when all is parsed
  }
  return words.size() - app.remaining_size();
}

}  // namespace gpsrecon::cli

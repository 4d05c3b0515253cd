#pragma once

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

namespace gpsrecon::test {

/// Checks JSON against a JSON Schema, draft 2020-12, as far as the project's schemas use it. A keyword that is not
/// known here is an error of its own, so that no rule of a schema is silently skipped.
class JsonSchema {
 public:
  explicit JsonSchema(nlohmann::json schema) : root_(std::move(schema)) {}

  /// Everything that is wrong, each with the path of the value; empty if the value is valid.
  std::vector<std::string> errors(const nlohmann::json& value) const {
    std::vector<std::string> found;
    check(root_, value, "", found);
    return found;
  }

 private:
  using Json = nlohmann::json;

  static bool has_type(const Json& value, const std::string& type) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "null") return value.is_null();
    if (type == "number") return value.is_number();
    if (type == "integer")
      return value.is_number_integer() ||
             (value.is_number_float() && value.get<double>() == std::floor(value.get<double>()));
    return false;
  }

  void check(const Json& schema, const Json& value, const std::string& path, std::vector<std::string>& found) const {
    const auto fail = [&](const std::string& what) { found.push_back((path.empty() ? "/" : path) + ": " + what); };
    for (const auto& [keyword, rule] : schema.items()) {
      if (keyword == "$schema" || keyword == "title" || keyword == "description" || keyword == "$defs") continue;
      if (keyword == "$ref") {
        const std::string target = rule.get<std::string>();
        if (target.rfind("#/", 0) != 0) {
          fail("reference " + target + " is not local");
          continue;
        }
        check(root_.at(Json::json_pointer(target.substr(1))), value, path, found);
      } else if (keyword == "type") {
        bool matches = false;
        for (const Json& type : rule.is_array() ? rule : Json::array({rule})) matches |= has_type(value, type);
        if (!matches) fail("is not of type " + rule.dump());
      } else if (keyword == "const") {
        if (value != rule) fail("is not " + rule.dump());
      } else if (keyword == "enum") {
        if (std::find(rule.begin(), rule.end(), value) == rule.end()) fail("is none of " + rule.dump());
      } else if (keyword == "oneOf") {
        int matching = 0;
        std::vector<std::string> nested;
        for (const Json& alternative : rule) {
          std::vector<std::string> errors;
          check(alternative, value, path, errors);
          if (errors.empty()) ++matching;
          nested.insert(nested.end(), errors.begin(), errors.end());
        }
        if (matching != 1) {
          fail("matches " + std::to_string(matching) + " alternatives instead of one");
          found.insert(found.end(), nested.begin(), nested.end());
        }
      } else if (keyword == "minimum") {
        if (value.is_number() && value.get<double>() < rule.get<double>()) fail("is less than " + rule.dump());
      } else if (keyword == "maximum") {
        if (value.is_number() && value.get<double>() > rule.get<double>()) fail("is more than " + rule.dump());
      } else if (keyword == "minItems") {
        if (value.is_array() && value.size() < rule.get<std::size_t>()) fail("has fewer items than " + rule.dump());
      } else if (keyword == "maxItems") {
        if (value.is_array() && value.size() > rule.get<std::size_t>()) fail("has more items than " + rule.dump());
      } else if (keyword == "pattern") {
        if (value.is_string() && !std::regex_search(value.get<std::string>(), std::regex(rule.get<std::string>())))
          fail("does not match " + rule.dump());
      } else if (keyword == "items") {
        if (value.is_array())
          for (std::size_t i = 0; i < value.size(); ++i) check(rule, value[i], path + "/" + std::to_string(i), found);
      } else if (keyword == "required") {
        if (value.is_object())
          for (const Json& name : rule)
            if (!value.contains(name.get<std::string>())) fail("lacks " + name.dump());
      } else if (keyword == "properties") {
        if (value.is_object())
          for (const auto& [name, property] : rule.items())
            if (value.contains(name)) check(property, value.at(name), path + "/" + name, found);
      } else if (keyword == "additionalProperties") {
        const Json known = schema.value("properties", Json::object());
        if (value.is_object())
          for (const auto& [name, property] : value.items()) {
            if (known.contains(name)) continue;
            if (rule.is_object())
              check(rule, property, path + "/" + name, found);
            else if (rule == Json(false))
              fail("has the unknown key \"" + name + "\"");
          }
      } else {
        fail("schema keyword \"" + keyword + "\" is not supported");
      }
    }
  }

  Json root_;
};

}  // namespace gpsrecon::test

#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace gpsrecon::test {

/// Checks JSON against a JSON Schema as far as draft 7 goes, with valijson.
class JsonSchema {
 public:
  explicit JsonSchema(const nlohmann::json& schema);
  ~JsonSchema();

  /// Everything that is wrong, each with the path of the value; empty if the value is valid.
  std::vector<std::string> errors(const nlohmann::json& value) const;

 private:
  struct Rules;
  std::unique_ptr<Rules> rules_;
};

}  // namespace gpsrecon::test

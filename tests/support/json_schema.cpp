#include "json_schema.h"

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

namespace gpsrecon::test {

using valijson::adapters::NlohmannJsonAdapter;

struct JsonSchema::Rules {
  valijson::Schema schema;
};

JsonSchema::JsonSchema(const nlohmann::json& schema) : rules_(std::make_unique<Rules>()) {
  valijson::SchemaParser(valijson::SchemaParser::kDraft7).populateSchema(NlohmannJsonAdapter(schema), rules_->schema);
}

JsonSchema::~JsonSchema() = default;

std::vector<std::string> JsonSchema::errors(const nlohmann::json& value) const {
  valijson::ValidationResults results;
  valijson::Validator().validate(rules_->schema, NlohmannJsonAdapter(value), &results);
  std::vector<std::string> found;
  for (const valijson::ValidationResults::Error& error : results) {
    std::string path;
    for (const std::string& part : error.context) path += part;
    found.push_back(path + ": " + error.description);
  }
  return found;
}

}  // namespace gpsrecon::test

#include <gpsrecon/core/ellipsoids.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/hem/likelihood.h>
#include <gpsrecon/measure/align.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/pipeline/point_normals.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <gpsrecon/report/html_report.h>
#include <gpsrecon/scan/virtual_scan.h>
#include <gtest/gtest.h>
#include <set>

// What holds for the table of every options struct.

namespace gpsrecon {

using namespace internal;
namespace {

template <class Options>
class Table : public testing::Test {};

using AllOptions = testing::Types<ScaleOptions, HemOptions, LikelihoodOptions, TriangulateOptions, FitOptions,
                                  SubdivideOptions, InferOptions, ReconstructOptions, CompareOptions, AlignOptions,
                                  HtmlOptions, ProjectionOptions, ProjectOptions, ParticleOptions, PointNormalsOptions,
                                  NormalOptions, PropagationOptions, ScanOptions, EllipsoidOptions>;
TYPED_TEST_SUITE(Table, AllOptions);

TYPED_TEST(Table, DefaultsAreInTheirRanges) {
  EXPECT_NO_THROW(TypeParam{}.check());
}

TYPED_TEST(Table, RowsAreNamedOnceAndSayWhatTheyMean) {
  std::set<std::string_view> names;
  for (const Field& row : TypeParam::fields()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(row.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0-"), std::string_view::npos) << row.name;
    EXPECT_FALSE(row.meaning.empty() || row.meaning.ends_with('.')) << row.name;
  }
}

TYPED_TEST(Table, DefaultsAreReadBackFromTheirText) {
  for (const Field& row : TypeParam::fields()) {
    TypeParam options;
    const std::string text = row.state(&options).text;
    ASSERT_NO_THROW(row.set(&options, text)) << row.name;
    EXPECT_EQ(row.state(&options).text, text) << row.name;
    EXPECT_NO_THROW(row.check(&options)) << row.name;
  }
}

/// Two rows with one member would change together.
TYPED_TEST(Table, EveryRowHasAMemberOfItsOwn) {
  for (const Field& row : TypeParam::fields()) {
    TypeParam options;
    std::vector<std::string> before;
    for (const Field& other : TypeParam::fields()) before.push_back(other.state(&options).text);
    for (const char* text : {"false", "true", "7", "0.5", "3%", "1,2,3", "keep", "5%"}) {
      try {
        row.set(&options, text);
      } catch (const OptionError&) {
      }
    }
    std::size_t changed = 0, i = 0;
    for (const Field& other : TypeParam::fields()) changed += other.state(&options).text != before[i++] ? 1 : 0;
    EXPECT_LE(changed, 1U) << row.name;
  }
}

}  // namespace
}  // namespace gpsrecon

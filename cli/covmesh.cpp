#include <gpsrecon/core/error.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/gps/edit.h>
#include <gpsrecon/io/io.h>
#include <sstream>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"
#include "repair.h"

namespace gpsrecon::cli {

using namespace internal;
namespace {

/// `text` split at `separator`, empty fields included.
std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> fields;
  std::istringstream stream(text);
  for (std::string field; std::getline(stream, field, separator);) fields.push_back(field);
  if (text.empty() || text.back() == separator) fields.emplace_back();
  return fields;
}

[[noreturn]] void expected(const std::string& what, const std::string& text) {
  throw OptionError("expected " + what + ", got '" + text + "'");
}

/// Numbers separated by commas, of which there must be as many as `counts` allows.
std::vector<double> parse_numbers(const std::string& text, const std::vector<std::size_t>& counts,
                                  const std::string& what) {
  std::vector<double> numbers;
  for (const std::string& field : split(text, ',')) numbers.push_back(parse_double(field));
  for (const std::size_t count : counts)
    if (numbers.size() == count) return numbers;
  expected(what, text);
}

/// "3,7-9"
SelectIndices parse_indices(const std::string& text) {
  constexpr const char* what = "all, indices such as 3,7-9, box:..., plane:... or nearest:...";
  SelectIndices selection;
  for (const std::string& field : split(text, ',')) {
    if (field.empty() || field.find_first_not_of("0123456789-") != std::string::npos) expected(what, text);
    const std::size_t dash = field.find('-');
    const std::uint64_t first = parse_natural(field.substr(0, dash));
    const std::uint64_t last = dash == std::string::npos ? first : parse_natural(field.substr(dash + 1));
    if (last < first || last >= no_index) expected(what, text);
    selection.ranges.push_back({static_cast<Index>(first), static_cast<Index>(last)});
  }
  return selection;
}

VertexSelection parse_selection(const std::string& text) {
  if (text == "all") return SelectAll{};
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return parse_indices(text);
  const std::string kind = text.substr(0, colon), rest = text.substr(colon + 1);
  if (kind == "box") {
    const auto n = parse_numbers(rest, {6}, "box:X0,Y0,Z0,X1,Y1,Z1");
    return SelectBox{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
  }
  if (kind == "plane") {
    const auto n = parse_numbers(rest, {6}, "plane:X,Y,Z,NX,NY,NZ");
    return SelectHalfSpace{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
  }
  if (kind == "nearest") {
    const std::size_t second = rest.find(':');
    const std::size_t count = second == std::string::npos ? 1 : parse_natural(rest.substr(0, second));
    return SelectNearest{parse_point(second == std::string::npos ? rest : rest.substr(second + 1)), count};
  }
  expected("all, indices such as 3,7-9, box:..., plane:... or nearest:...", text);
}

/// A standard deviation, three of them along the axes, or xx,xy,xz,yy,yz,zz of a covariance.
Sym3 parse_covariance(const std::string& text) {
  const auto n = parse_numbers(text, {1, 3, 6}, "S, SX,SY,SZ or XX,XY,XZ,YY,YZ,ZZ");
  if (n.size() == 6) return {n[0], n[1], n[2], n[3], n[4], n[5]};
  for (const double deviation : n)
    if (deviation < 0) expected("standard deviations that are not negative", text);
  if (n.size() == 1) return Sym3::identity(n[0] * n[0]);
  return Sym3::diagonal(n[0] * n[0], n[1] * n[1], n[2] * n[2]);
}

/// AXIS:FACTOR
FlattenCovariance parse_flatten(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) expected("AXIS:X", text);
  const std::string axis = text.substr(0, colon);
  FlattenCovariance operation;
  operation.factor = parse_double(text.substr(colon + 1));
  if (axis == "smallest") {
    operation.axis = Axis::smallest;
  } else if (axis == "middle") {
    operation.axis = Axis::middle;
  } else if (axis == "largest") {
    operation.axis = Axis::largest;
  } else {
    operation.axis = Axis::given;
    operation.direction = parse_point(axis);
  }
  return operation;
}

/// COVARIANCE[:FLOOR]
SharpenCovariance parse_sharpen(const std::string& text) {
  const std::size_t colon = text.find(':');
  SharpenCovariance operation{parse_covariance(text.substr(0, colon))};
  if (colon != std::string::npos) operation.floor = parse_double(text.substr(colon + 1));
  return operation;
}

/// Operations in the order of the command line, each on what was selected last before it.
class Script {
 public:
  void bind(Arguments& arguments) {
    arguments.group("Steps, in the order in which they are given");
    arguments.sequence("--select", "SELECTION",
                       "the vertices that the steps after it apply to: all, a list of indices "
                       "such as 3,7-9 counted from 0, box:X0,Y0,Z0,X1,Y1,Z1, the side plane:X,Y,Z,NX,NY,NZ of a plane "
                       "to which its normal points, or nearest:X,Y,Z or nearest:N:X,Y,Z, the one or N nearest to a "
                       "point",
                       "", "all", [this](const std::string& text) {
                         selection_ = parse_selection(text);
                         EditStep{selection_, ScaleCovariance{}}.check();
                         unused_selection_ = true;
                       });
    bind_step(arguments, "--scale", "X", "multiply the covariance by X", "[1e-12, 1e12]",
              [](const std::string& text) { return ScaleCovariance{parse_double(text)}; });
    bind_step(arguments, "--flatten", "AXIS:X",
              "multiply the variance along an axis by X; AXIS: smallest, middle or largest (the eigenvector) or a "
              "direction X,Y,Z",
              "[1e-12, 1e12]", parse_flatten);
    bind_step(arguments, "--smooth", "C",
              "convolve with a Gaussian: add its covariance. C: a standard deviation in the unit of the coordinates, "
              "three along the axes SX,SY,SZ, or a covariance XX,XY,XZ,YY,YZ,ZZ",
              "", [](const std::string& text) { return SmoothCovariance{parse_covariance(text)}; });
    bind_step(arguments, "--sharpen", "C[:F]",
              "the opposite: subtract the covariance, and leave every variance at least F (1e-6) times the largest "
              "before",
              "F in [1e-12, 1]", parse_sharpen);
    bind_step(arguments, "--set", "C", "give all the covariance C", "positive definite",
              [](const std::string& text) { return SetCovariance{parse_covariance(text)}; });
  }

  /// The steps that were given. Throws OptionError for a selection that nothing follows.
  const std::vector<EditStep>& steps() const {
    if (unused_selection_) throw OptionError("--select: no step follows the last one");
    return steps_;
  }

  /// What each step did, under the name of its option.
  void tell(const std::vector<EditCounts>& counts, const Console& console) const {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const std::string step = "step " + std::to_string(i + 1) + " (" + names_[i] + "): ";
      console.info(step + std::to_string(counts[i].selected) + " vertices");
      if (counts[i].floored > 0)
        console.warn(step + std::to_string(counts[i].floored) + " covariances were kept from becoming flatter");
      if (counts[i].ambiguous_axes > 0)
        console.warn(step + std::to_string(counts[i].ambiguous_axes) +
                     " covariances are as wide along another axis: which of them was taken is arbitrary");
    }
  }

 private:
  template <class Parse>
  void bind_step(Arguments& arguments, const std::string& name, const std::string& value_name,
                 const std::string& meaning, const std::string& range, const Parse& parse) {
    arguments.sequence(name, value_name, meaning, range, "none", [this, name, parse](const std::string& text) {
      steps_.push_back({selection_, parse(text)});
      steps_.back().check();
      names_.push_back(name.substr(2));
      unused_selection_ = false;
    });
  }

  VertexSelection selection_ = SelectAll{};
  std::vector<EditStep> steps_;
  std::vector<std::string> names_;
  bool unused_selection_ = false;
};

Mesh control_mesh(const CovMesh& covmesh) {
  Mesh mesh;
  mesh.positions = covmesh.vertices.means;
  mesh.colors = covmesh.vertices.colors;
  mesh.scalars = covmesh.vertices.scalars;
  mesh.frame = covmesh.vertices.frame;
  mesh.faces = covmesh.faces;
  return mesh;
}

}  // namespace

ExitCode run_covmesh(Arguments& arguments) {
  std::string in, out;
  Script script;
  RepairOptions repair;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("COVMESH", in, "covariance mesh (ply; - is standard input)");
  arguments.positional(
      "OUT", out, "covariance mesh (ply; - is standard output), or its means and faces alone (obj, off, stl, glb)");
  script.bind(arguments);
  GivenRules rules;
  rules.bind(arguments);
  arguments.group("Input");
  arguments.fields(repair);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  const std::vector<EditStep>& steps = script.steps();
  Outputs outputs(globals, {{"COVMESH", in}});
  const bool mesh_only = is_mesh_only(out);
  outputs.plan({"OUT", out}, mesh_only);
  const Console console(globals);

  const RunContext context = console.context();
  const Edit edited = edit(rules.over(load_covmesh(in, repair.repair, console), in), steps, context);
  script.tell(edited.steps, console);

  if (mesh_only) {
    console.warn(out + ": the format has no place for covariances; that of .ply has");
    const Mesh mesh = control_mesh(edited.mesh);
    warn_of_losses(mesh, out, console);
    outputs.stage(out, [&](const std::string& path) { write_mesh(mesh, path, encoding); });
  } else {
    outputs.stage(out, [&](const std::string& path) { write_covmesh(edited.mesh, path, encoding); });
  }
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli

// Tests that every number of a scene is accepted at both ends of its range and refused just outside, with the matching
// message, by the reader and by the library.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "bone/material/region_table.h"
#include "cut/hand_sim/setup.h"
#include "device/devices/simulated_device.h"
#include "loop/haptics/haptic_loop.h"
#include "scene_text.h"
#include "session/scene/schema.h"
#include "support/message_of.h"

namespace kerf {
namespace {

/// Visits a description and tests each key separately: `make_text` inserts `key = value` into an otherwise valid scene.
class RangeTester {
 public:
  RangeTester(std::function<std::string(const std::string& key, const std::string& value)> make_text)
      : make_text_(std::move(make_text)) {}

  void operator()(const char* key, double& value, Range range, const char* meaning) {
    EXPECT_GE(value, range.lower) << key;  // the default
    EXPECT_LE(value, range.upper) << key;
    EXPECT_FALSE(std::string(meaning).empty()) << key;
    for (const double x : {range.lower, range.upper}) Accepts(key, fmt::format("{}", x));
    const double below = std::nextafter(range.lower, -std::numeric_limits<double>::infinity());
    const double above = std::nextafter(range.upper, std::numeric_limits<double>::infinity());
    Refuses(key, fmt::format("{}", below),
            fmt::format("{} = {} is below {}; valid range {}", key, below, range.lower, Show(key, range)));
    Refuses(key, fmt::format("{}", above),
            fmt::format("{} = {} is above {}; valid range {}", key, above, range.upper, Show(key, range)));
    for (const char* word : {"nan", "inf", "-inf"}) {
      Refuses(key, word, fmt::format("{} = {} is not a finite number; valid range {}", key, word, Show(key, range)));
    }
    Refuses(key, "\"much\"",
            fmt::format("{} = \"much\" is a string; it must be a number from {}", key, Show(key, range)));
    Refuses(key, "[1]", fmt::format("{} is a list; it must be a number from {}", key, Show(key, range)));
  }
  void operator()(const char* key, int& value, Range range, const char*) {
    EXPECT_GE(value, range.lower) << key;
    EXPECT_LE(value, range.upper) << key;
    for (const double x : {range.lower, range.upper}) Accepts(key, fmt::format("{}", x));
    const double below = range.lower - 1;
    const double above = range.upper + 1;
    Refuses(key, fmt::format("{}", below),
            fmt::format("{} = {} is below {}; valid range {}", key, below, range.lower, Show(key, range)));
    Refuses(key, fmt::format("{}", above),
            fmt::format("{} = {} is above {}; valid range {}", key, above, range.upper, Show(key, range)));
    // 2^32 plus the lower end must not wrap around into the range.
    const double wrapped = 4294967296.0 + range.lower;
    Refuses(key, fmt::format("{:.0f}", wrapped), fmt::format("{} = {:.0f} is above", key, wrapped));
    Refuses(key, "1.5", fmt::format("{} = 1.5 is a number; it must be a whole number from {}", key, Show(key, range)));
  }
  void operator()(const char* key, bool&, const char*) {
    Refuses(key, "1", fmt::format("{} = 1 is a number; it must be true or false", key));
  }
  void operator()(const char* key, Vec3&, Range range, const char*) {
    for (int i = 0; i < 3; ++i) {
      const auto list = [&](double x) {
        return fmt::format("[{}, {}, {}]", i == 0 ? x : 1, i == 1 ? x : 1, i == 2 ? x : 1);
      };
      Accepts(key, list(range.lower));
      Accepts(key, list(range.upper));
      const double above = std::nextafter(range.upper, std::numeric_limits<double>::infinity());
      const double below = std::nextafter(range.lower, -std::numeric_limits<double>::infinity());
      Refuses(key, list(above),
              fmt::format("{}[{}] = {} is above {}; valid range {}", key, i, above, range.upper, Show(key, range)));
      Refuses(key, list(below),
              fmt::format("{}[{}] = {} is below {}; valid range {}", key, i, below, range.lower, Show(key, range)));
      Refuses(key, list(std::numeric_limits<double>::quiet_NaN()),
              fmt::format("{}[{}] = nan is not a finite number", key, i));
    }
    Refuses(key, "[1, 2]", fmt::format("{} has 2 items; it must be a list of three numbers [x, y, z] from", key));
    Refuses(key, "3", fmt::format("{} = 3 is a number; it must be a list of three numbers", key));
  }
  void operator()(const char* key, Quat&, const char*) {
    Accepts(key, "[0.5, -0.5, 0.5, 0.5]");
    Refuses(key, "[1, 0, 0, 0.1]", fmt::format("{} has length 1.004988; it must be a unit quaternion", key));
  }
  void operator()(const char* key, std::string&, const Choices& choices, const char*) {
    for (const std::string_view word : choices.words) Accepts(key, fmt::format("\"{}\"", word));
    Refuses(key, "\"none\"",
            fmt::format("{} = \"none\" is unknown; it must be \"{}\"", key, fmt::join(choices.words, "\" or \"")));
  }

  int tried() const { return tried_; }

 private:
  static std::string Show(const char* key, Range range) { return ShowRange(range, UnitOfKey(key)); }
  void Accepts(const char* key, const std::string& value) {
    ++tried_;
    EXPECT_EQ(test::MessageFor(make_text_(key, value)), "") << key << " = " << value;
  }
  void Refuses(const char* key, const std::string& value, const std::string& what) {
    ++tried_;
    const std::string message = test::MessageFor(make_text_(key, value));
    EXPECT_NE(message.find(what), std::string::npos) << "said: " << message << "\nwanted: " << what;
    EXPECT_EQ(message.rfind("s.toml:", 0), 0U) << message;
  }

  std::function<std::string(const std::string&, const std::string&)> make_text_;
  int tried_ = 0;
};

RangeTester ForSection(const std::string& header) {
  return RangeTester([header](const std::string& key, const std::string& value) {
    return test::ShortScene() + header + "\n" + key + " = " + value + "\n";
  });
}

TEST(SceneRange, ToolKeysEnforceTheirRanges) {
  RangeTester tester = ForSection("[tool]");
  SceneTool tool;
  Describe(tool, tester);
  EXPECT_GT(tester.tried(), 60);
}

TEST(SceneRange, ForceSimulationAndOutputKeysEnforceTheirRanges) {
  // The keys of the density are read with density_exponent only.
  const auto of_law = [](const std::string& law) {
    return RangeTester([law](const std::string& key, const std::string& value) {
      const bool needs_density = key == "modulus_exponent" || key == "reference_E_MPa";
      return fmt::format("{}[force]\n{}{}{} = {}\n", test::ShortScene(), law,
                         needs_density ? "density_exponent = 1\n" : "", key, value);
    });
  };
  RangeTester force = of_law("");
  ForceLaw law;
  Describe(law, force);
  for (const ForceLawInfo* info : ForceLaws()) {
    RangeTester own = of_law(fmt::format("law = \"{}\"\n", info->name));
    ForceLaw of_this(info->name);
    DescribeLawParameters(of_this, own);
    EXPECT_GT(own.tried(), 8) << info->name;
  }
  RangeTester simulation = ForSection("[simulation]");
  SceneSimulation sim;
  Describe(sim, simulation);
  RangeTester output = ForSection("[output]");
  SceneOutput out;
  Describe(out, output);
  EXPECT_GT(force.tried() + simulation.tried() + output.tried(), 40);
}

TEST(SceneRange, SlabKeysEnforceTheirRanges) {
  // A held segment must be free to move. If x of `direction` [0, x, 0] is at the end of its range, the vector still has
  // a direction.
  RangeTester tester([](const std::string& key, const std::string& value) {
    return test::ShortScene() + "[slab]\n" + (key == "hold" ? "segments_move = true\n" : "") + key + " = " + value +
           "\n";
  });
  SceneSlab slab;
  Describe(slab, tester);
  EXPECT_GT(tester.tried(), 80);
}

TEST(SceneRange, HandHeldKeysEnforceTheirRanges) {
  RangeTester coupling = ForSection("[coupling]");
  SceneCoupling of_coupling;
  Describe(of_coupling, coupling);
  RangeTester device = ForSection("[device]");
  SceneDevice of_device;
  Describe(of_device, device);
  RangeTester hand = ForSection("[hand]");
  SceneHand of_hand;
  Describe(of_hand, hand);
  RangeTester loop = ForSection("[loop]");
  SceneLoop of_loop;
  Describe(of_loop, loop);
  EXPECT_GT(coupling.tried() + device.tried() + hand.tried() + loop.tried(), 150);
}

TEST(SceneRange, ExerciseKeysEnforceTheirRanges) {
  RangeTester tester = ForSection("[tool]\nshape = \"bur\"\n[exercise]");
  SceneExercise exercise;
  Describe(exercise, tester);
  EXPECT_GT(tester.tried(), 100);
}

TEST(SceneRange, UniformMaterialKeysEnforceTheirRanges) {
  RangeTester tester = ForSection("[material]\nkind = \"uniform\"");
  SceneMaterial material;
  DescribeUniform(material, tester);
  EXPECT_GT(tester.tried(), 15);
}

TEST(SceneRange, BlockKeysEnforceTheirRanges) {
  RangeTester tester = ForSection("[bone.block]");
  BlockParams block;
  Describe(block, tester);
  RangeTester layer([](const std::string& key, const std::string& value) {
    const std::string other = key == "region" ? "thickness_mm = 1" : "region = 1";
    return test::ShortScene() + "[[bone.block.layer]]\n" + other + "\n" + key + " = " + value + "\n";
  });
  MaterialLayer params;
  params.thickness_mm = 1;
  Describe(params, layer);
  EXPECT_GT(tester.tried() + layer.tried(), 40);
}

TEST(SceneRange, MandibleKeysEnforceTheirRanges) {
  RangeTester tester([](const std::string& key, const std::string& value) {
    std::string text = test::ShortScene();
    text.replace(text.find("block"), 5, "mandible");
    return text + "[bone.mandible]\n" + key + " = " + value + "\n";
  });
  MandibleParams mandible;
  Describe(mandible, tester);
  EXPECT_GT(tester.tried(), 200);
}

TEST(SceneRange, StrokeKeysEnforceTheirRanges) {
  // A stroke with all keys; the one under test is replaced.
  RangeTester tester([](const std::string& key, const std::string& value) {
    std::string text = "[bone]\nmodel = \"block\"\n[[path.stroke]]\n";
    const std::vector<std::pair<std::string, std::string>> keys{{"start_mm", "[0, 0, 0]"}, {"end_mm", "[1, 0, 0]"},
                                                                {"feed_mm_per_s", "300"},  {"disc_normal", "[0, 1, 0]"},
                                                                {"dwell_s", "1"},          {"retract", "true"}};
    for (const auto& [k, v] : keys) text += k + " = " + (k == key ? value : v) + "\n";
    return text;
  });
  SceneStroke stroke;
  Describe(stroke, tester);
  EXPECT_GT(tester.tried(), 60);
}

/// Visits a description whose values the library uses too, and tests that the library accepts the same values as the
/// scene reader. `check` throws if the library refuses the current values.
class LibraryTester {
 public:
  LibraryTester(std::set<std::string> scene_only, std::function<void()> check)
      : scene_only_(std::move(scene_only)), check_(std::move(check)) {}

  template <typename Number>
  void operator()(const char* key, Number& value, Range range, const char*) {
    if (scene_only_.contains(key)) return;
    const Number before = value;
    for (const double end : {range.lower, range.upper}) {
      value = static_cast<Number>(end);
      EXPECT_EQ(test::MessageOf(check_), "") << key << " = " << end;
      const double outside = end == range.lower ? -kInfinity : kInfinity;
      value = std::is_integral_v<Number> ? static_cast<Number>(end + (outside < 0 ? -1 : 1))
                                         : static_cast<Number>(std::nextafter(end, outside));
      EXPECT_THAT(test::MessageOf(check_), testing::HasSubstr("valid range")) << key << " beyond " << end;
    }
    value = before;
    ++tried_;
  }
  void operator()(const char* key, Vec3& value, Range range, const char* meaning) {
    for (int i = 0; i < 3; ++i) (*this)(key, value[i], range, meaning);
  }
  template <typename... Rest>
  void operator()(const char*, Rest&&...) {}

  int tried() const { return tried_; }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::set<std::string> scene_only_;
  std::function<void()> check_;
  int tried_ = 0;
};

TEST(SceneRange, LibraryAcceptsTheSameTools) {
  Scene scene;
  for (const Tool& tool : GetDefaultTools()) {
    scene.tool.shape = tool;
    LibraryTester tester({"rpm"}, [&] { Validate(MakeTool(scene)); });
    Describe(scene.tool, tester);
    int shape_keys = 0;
    std::visit([&](auto& shape) { DescribeShape(shape, [&](const char*, const auto&...) { ++shape_keys; }); },
               scene.tool.shape);
    EXPECT_EQ(tester.tried(), 7 + shape_keys);
  }
}

TEST(SceneRange, LibraryAcceptsTheSameSimulationAndCoupling) {
  Scene scene;
  for (const bool coupled : {false, true}) {
    LibraryTester simulation({"rate_hz"}, [&] {
      if (coupled) {
        CheckParams(MakeCoupledParams(scene));
      } else {
        Simulation(MakeBlock({{2, 2, 2}, {}, {}, 0.5}, DefaultMandibleTable()), MakeSimulationParams(scene),
                   {{1, 0, 0, 0}, {0, 0, 50}});
      }
    });
    Describe(scene.simulation, simulation);
    EXPECT_EQ(simulation.tried(), 3);
  }
  LibraryTester coupling({}, [&] { CheckParams(MakeCoupledParams(scene)); });
  Describe(scene.coupling, coupling);
  EXPECT_EQ(coupling.tried(), 6);
}

TEST(SceneRange, LibraryAcceptsTheSameSlabs) {
  Scene scene;
  SlabProfile profile;
  profile.layers = {{0, 24, 19300, 0.28}};
  profile.end_mm = 10;
  LibraryTester tester({"direction"}, [&] {
    SlabSimulation(profile, MakeSlabParams(scene), Pose{{1, 0, 0, 0}, {0, -20, 0}});
  });
  Describe(scene.slab, tester);
  EXPECT_EQ(tester.tried(), 11);
}

TEST(SceneRange, LibraryAcceptsTheSameDevicesAndLoops) {
  SceneDevice device;
  LibraryTester of_device({}, [&] {
    ForceMap(DeviceProfile{}, {.expected_peak_N = device.expected_peak_N,
                               .expected_peak_torque_Nmm = device.expected_peak_torque_Nmm,
                               .slew_N_per_s = device.slew_N_per_s,
                               .ramp_in_s = device.ramp_s});
    const SimulatedDevice simulated(DeviceProfile{}, HandModel{}, Pose{}, {.delay_ticks = device.delay_ticks});
    Workspace({.motion_scale = device.motion_scale});
  });
  Describe(device, of_device);
  EXPECT_EQ(of_device.tried(), 6);
  SceneLoop loop;
  LibraryTester of_loop({}, [&] {
    LoopParams params;
    params.rate_hz = loop.rate_hz;
    params.watchdog_ms = loop.watchdog_ms;
    params.leaves_per_tick = loop.publish_leaves_per_tick;
    params.governor.budget_share = loop.budget_share;
    params.governor.overrun_share = loop.overrun_share;
    params.governor.calm_s = loop.calm_s;
    CheckParameters(params);
  });
  Describe(loop, of_loop);
  EXPECT_EQ(of_loop.tried(), 6);
}

TEST(SceneRange, LibraryAcceptsTheSameBlocksAndPlans) {
  MaterialTable materials;
  for (const int id : {1, 24, 255}) materials.Add({id, "test", Tissue::kCortical, 19300, 0.28, true, "test"});
  BlockParams block;
  LibraryTester of_block({}, [&] { CheckBlock(block, materials); });
  Describe(block, of_block);
  EXPECT_EQ(of_block.tried(), 7);
  block.layers = {{1, 24}};
  Describe(block.layers[0], of_block);
  EXPECT_EQ(of_block.tried(), 9);
  Plan plan;
  plan.planes.emplace_back().name = "a";
  plan.stops.emplace_back().name = "b";
  LibraryTester of_plan({"normal", "direction"}, [&] { CheckPlan(plan); });
  Describe(plan.planes[0], of_plan);
  Describe(plan.stops[0], of_plan);
  EXPECT_EQ(of_plan.tried(), 13);
}

TEST(SceneRange, LibraryAcceptsTheSameForceLaws) {
  for (const ForceLawInfo* info : ForceLaws()) {
    ForceLaw law(info->name);
    LibraryTester tester({}, [&] { MakeToothForce(law, DiscSaw{}); });
    DescribeLawParameters(law, tester);
    EXPECT_EQ(static_cast<std::size_t>(tester.tried()), info->parameters.size());
  }
}

TEST(SceneRange, BallHasItsOwnDefaultDiameter) {
  EXPECT_EQ(CalcReach(MakeTool(ParseScene(test::ShortScene() + "[tool]\nshape = \"ball\"\n", "s.toml"))), 3);
  EXPECT_EQ(
      CalcReach(MakeTool(ParseScene(test::ShortScene() + "[tool]\ndiameter_mm = 8\nshape = \"ball\"\n", "s.toml"))), 4);
}

}  // namespace
}  // namespace kerf

// The yardstick of rooms, in rooms whose answer is known: what it measures is what is wrong with a drawing.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "models/mesh/generated.h"
#include "models/rooms/panorama_file.h"
#include "tests/laboratory/room/room_study.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

using tests::TemporaryFolder;

// An even room, and one with a lamp of 6 degrees at 45 degrees above the azimuth that is given.
RadianceMap room_with_lamp(double azimuth_deg, double lamp) {
  const double a = azimuth_deg * 3.14159265358979 / 180.0, half = std::sqrt(0.5);
  const Vec3 towards = {half * std::cos(a), half, half * std::sin(a)};
  return panorama_of(128, 64, [&](Vec3 d) {
    return Vec3{1, 1, 1} * (dot(d, towards) > std::cos(6.0 * 3.14159265358979 / 180.0) ? lamp : 0.5);
  });
}

ThreadPool& single() {
  static ThreadPool pool(1);
  return pool;
}

const FloorObject& pole() {
  static const float size[3] = {0.1f, 0.4f, 0.1f};
  static const FloorObject object("pole", make_box(size), 1, &single());
  return object;
}

RoomStudy study_of(const std::vector<RadianceMap>& rooms, const TemporaryFolder& folder) {
  RoomStudyOptions options;
  for (size_t i = 0; i < rooms.size(); ++i) {
    options.panoramas.push_back(folder / ("room_" + std::to_string(i) + ".hdr"));
    write_hdr(options.panoramas.back(), rooms[i]);
  }
  options.azimuths = 2;
  return study_rooms(options, std::make_shared<const std::vector<FloorObject>>(1, pole()));
}

// In an even room ambient occlusion is the truth, and so is every session's answer. What is left is the sampling of
// the truth's 1,024 rays: the two sides share them, so it cancels.
TEST(RoomStudy, InAnEvenRoomAmbientOcclusionIsTheTruth) {
  const TemporaryFolder folder;
  const RoomStudy study = study_of({room_with_lamp(0, 0.5)}, folder);
  const RoomTable table = room_table(study, &single());
  EXPECT_LT(row_of(table.drawn, "ambient occlusion alone").floor.mean, 0.005);
  EXPECT_LT(row_of(table.drawn, "the true light in cells").floor.mean, 0.005);
  for (const Session session : k_sessions)
    EXPECT_LT(row_of(table.drawn, session_name(session)).floor.mean, 0.02) << session_name(session);
  EXPECT_GT(row_of(table.drawn, "no shadow").floor.mean, 0.05);
  const SessionRow& everything = table.sessions[static_cast<size_t>(Session::everything)];
  EXPECT_GT(everything.seen.mean, 0.98);
  EXPECT_LT(everything.level.mean, 0.05);
}

// A lamp that gives half of the floor's light: its irradiance is pi sin^2(6 deg) L / sqrt 2, that of the rest 0.5 pi.
TEST(RoomStudy, ALampIsDrawnTheBetterTheMoreWasSeen) {
  const TemporaryFolder folder;
  const double radiance = 0.5 * std::sqrt(2.0) / std::pow(std::sin(6.0 * 3.14159265358979 / 180.0), 2);
  const RoomStudy study = study_of({room_with_lamp(100, radiance), room_with_lamp(250, radiance)}, folder);
  const RoomTable table = room_table(study, &single());
  const double ambient = row_of(table.drawn, "ambient occlusion alone").floor.mean;
  EXPECT_LT(row_of(table.drawn, "the true light in cells").floor.mean, 0.6 * ambient);
  const double everything = row_of(table.drawn, session_name(Session::everything)).floor.mean;
  const double turn = row_of(table.drawn, session_name(Session::full_turn)).floor.mean;
  EXPECT_LT(everything, 0.7 * ambient);
  EXPECT_LT(turn, ambient);
  EXPECT_LT(everything, turn);
  EXPECT_NEAR(row_of(table.drawn, session_name(Session::table)).floor.mean, ambient, 0.1 * ambient);
  EXPECT_GT(row_of(table.drawn, "control: a full turn, mirrored").floor.mean, turn);
  EXPECT_GT(row_of(table.drawn, "control: a full turn in another room").floor.mean, turn);
  EXPECT_LT(table.sessions[static_cast<size_t>(Session::everything)].direction_deg.mean, 5.0);
  // The label is the lamp: half of the light. Alone it leaves the rest unshaded; with ambient occlusion nearly nothing.
  EXPECT_LT(row_of(table.drawn, "one light, the true label").floor.mean, row_of(table.drawn, "no shadow").floor.mean);
  EXPECT_LT(row_of(table.drawn, "the true label and ambient occlusion").floor.mean, 0.6 * ambient);
}

TEST(RoomStudy, ItsLimitsAreHeldByGoodRowsAndBrokenByBadOnes) {
  RoomTable table;
  const auto add = [&](const std::string& name, double share, Interval none, Interval ambient, bool control = false) {
    DrawnRow row;
    row.name = name;
    row.share_of_ambient = share;
    row.against_none = none;
    row.against_ambient = ambient;
    row.control = control;
    table.drawn.push_back(row);
  };
  add("the true light in cells", 0.4, {-0.1, -0.2, -0.05}, {-0.04, -0.05, -0.03});
  for (const Session session : k_sessions) add(session_name(session), 0.7, {-0.1, -0.2, -0.05}, {-0.01, -0.02, -0.001});
  for (const ProbeVariant& variant : k_probe_variants)
    if (!variant.control) add(variant.name, variant.limit, {0, 0, 0}, {-0.01, -0.02, -0.001});
  add("control: worse", 1.2, {0, 0, 0}, {0.01, 0.005, 0.02}, true);
  table.sessions.resize(std::size(k_sessions));
  table.unguarded.mean = 0.4;
  const auto failed = [](const RoomTable& t) {
    int count = 0;
    for (const Verdict& v : room_verdicts({{"all rooms", t}})) count += v.pass ? 0 : 1;
    return count;
  };
  EXPECT_EQ(failed(table), 0);
  RoomTable worse = table;
  worse.drawn[0].share_of_ambient = 0.51;
  EXPECT_EQ(failed(worse), 1);
  worse = table;
  worse.drawn[1 + static_cast<size_t>(Session::full_turn)].share_of_ambient = 0.76;
  worse.drawn[1 + static_cast<size_t>(Session::table)].against_ambient.high = 0.0011;
  EXPECT_EQ(failed(worse), 2);
  worse = table;
  (worse.drawn.end() - 2)->share_of_ambient += 0.01;  // a probe
  EXPECT_EQ(failed(worse), 1);
  worse = table;
  worse.drawn.back().against_ambient.mean = -0.001;  // the control is as good
  worse.sessions[static_cast<size_t>(Session::full_turn)].direction_deg.mean = 15.1;
  EXPECT_EQ(failed(worse), 2);
}

}  // namespace
}  // namespace sandglass::host

// What an image says of its exposure, and of the light of the whole room.
//
// Each part that is remembered and shown again votes with the ratio of what the image shows to what is remembered. The
// weighted median of the votes is how much brighter the image is. A clipped part is only known to be brighter, a black
// one to be darker: they stand at the ends. With exposures that are told the median is a change of the room's light; else
// it is the exposure.
//
// The light of the whole room is one factor beside its parts. So what is out of the picture follows at once, and a change
// and its return cancel. For some time after a change the parts themselves are left alone, while the factor follows each
// image. What no change of light explains, a finger over the lens, is not believed at once either; and what is black or
// clipped almost everywhere teaches nothing.
#include "runtime/core/luminance.h"
#include "runtime/core/math.h"
#include "runtime/room/room.h"

namespace sandglass {

namespace {

constexpr double k_bin = 0.25, k_lowest = -0.5 * k_bin * k_vote_bins;  // of ratios
constexpr double k_memory = 0.3, k_memory_clipped = 0.01;
// Linear values. Black is one step of a byte: an image that is exposed for a 64th shows little more of a wall. What is
// darker than `dim` says nothing of a change, because bytes round it; unless it was or is brighter.
constexpr double k_black = 0.00031, k_dim = 0.01, k_white_from = 0.5;
constexpr double k_scale_least = 1.0, k_change_least = 8.0, k_doubt_least = 3.0;  // weights that are compared at least
// The light of the whole room has changed where two thirds of what is seen again are brighter or darker by half.
constexpr double k_change = 0.405, k_change_share = 0.65, k_perhaps_share = 0.35;
constexpr double k_blind = 0.8, k_half_blind = 0.5, k_all_black = 0.98;
// A change of light keeps most of the pattern of what is seen, and its hue: daylight beside a warm bulb are a factor of
// 1.6 of red and 2.7 of blue. A thing before the lens keeps neither.
constexpr double k_pattern_least = 0.05, k_pattern_lost = 0.75, k_other_red = 0.7, k_other_blue = 1.2;
constexpr double k_noise = 0.3, k_usual_rate = 0.1, k_missing_rate = 0.3;
constexpr double k_short_ratio = 3.0;  // an image so much darker is a short one: bytes have lost its pattern
constexpr double k_patience = 2.5, k_settling = 3.0;  // seconds
constexpr double k_scale_most = 1e6;

double bounded(double x) { return x < 1 / k_scale_most ? 1 / k_scale_most : x > k_scale_most ? k_scale_most : x; }

void add(float* sum, double value) { *sum += static_cast<float>(value); }

// Out of line: it is called from many places, and long.
__attribute__((noinline)) double logarithm_of(double x) { return logarithm(x > 0.5 * k_black ? x : 0.5 * k_black); }

// The median, at the mean of the votes about it.
double median_of(const RoomVote& v) {
  double total = static_cast<double>(v.brighter) + static_cast<double>(v.darker);
  for (const float w : v.weight) total += static_cast<double>(w);
  double below = static_cast<double>(v.darker);
  if (v.darker > 0 && below >= 0.5 * total) return static_cast<double>(v.darker_sum / v.darker);
  for (uint32_t i = 0; i < k_vote_bins; ++i) {
    below += static_cast<double>(v.weight[i]);
    if (!(v.weight[i] > 0) || below < 0.5 * total) continue;
    double weight = 0, sum = 0;
    for (uint32_t k = i > 0 ? i - 1 : 0; k <= i + 1 && k < k_vote_bins; ++k) {
      weight += static_cast<double>(v.weight[k]);
      sum += static_cast<double>(v.sum[k]);
    }
    return sum / weight;
  }
  return v.brighter > 0 ? static_cast<double>(v.brighter_sum / v.brighter) : 0;
}

// Whether the image shows something else than the room in another light.
bool is_strange(const RoomVote& v) {
  const auto exact = static_cast<double>(v.exact);
  if (exact < k_change_least || absolute(median_of(v)) > k_short_ratio) return false;
  double hue[3];
  for (int c = 0; c < 3; ++c)
    hue[c] = logarithm_of(static_cast<double>(v.now[c])) - logarithm_of(static_cast<double>(v.then[c]));
  const double red = hue[0] - hue[1], blue = hue[2] - hue[1];
  if (absolute(red) > k_other_red || absolute(blue) > k_other_blue) return true;
  const auto variance = [exact](float sum, float squares) {
    const double mean = static_cast<double>(sum) / exact;
    return static_cast<double>(squares) / exact - mean * mean;
  };
  const double pattern = variance(v.known, v.known_squared);
  return pattern > k_pattern_least && variance(v.error, v.error_squared) > k_pattern_lost * pattern;
}

// How the image is exposed, where that is not told.
double found_scale(const Room& room) {
  const RoomVote& v = room.view.vote;
  return static_cast<double>(v.exact) >= k_scale_least ? bounded(room.scale * exponential(-median_of(v))) : room.scale;
}

// While the light settles the factor follows each image. Small differences are the noise of where the votes were taken:
// of them the mean is taken.
void follow_light(Room* room, double change) {
  const double step = room->view.step, rate = step > 0 ? step / (room->settled + step) : 1;
  room->light = bounded(room->light * exponential(absolute(change) < k_noise ? rate * change : change));
}

RoomLesson lesson_of(Room* room, bool told) {
  const RoomVote& v = room->view.vote;
  const double hidden = static_cast<double>(v.brighter) + static_cast<double>(v.darker);
  const double compared = static_cast<double>(v.exact) + hidden;
  const bool enough = compared >= k_change_least;
  const bool black = static_cast<double>(v.black) >= k_all_black * static_cast<double>(v.area);
  if (black || (enough && hidden >= k_blind * compared)) {
    room->doubted += room->view.step;
    return RoomLesson::nothing;
  }
  const double one_way = static_cast<double>(v.more > v.less ? v.more : v.less);
  const bool perhaps = told && compared > 0 && one_way >= k_perhaps_share * compared;
  const bool clear = hidden <= (1 - k_blind) * compared;
  const bool strange = clear && (perhaps || !told) && is_strange(v);
  const bool surely = told && enough && one_way >= k_change_share * compared;
  // An image of which little can be compared, such as a short one, begins no doubt and ends none.
  const bool compares = compared >= k_doubt_least;
  const bool doubtful = strange || (perhaps && !surely && (enough || room->doubted > 0));
  if (compares) room->doubted = doubtful ? room->doubted + room->view.step : 0;
  if (!compares && room->doubted > 0) return RoomLesson::unknown;
  if (doubtful && room->doubted < k_patience) return strange ? RoomLesson::nothing : RoomLesson::unknown;
  // After so long what half of the parts say is believed.
  if (surely || (doubtful && enough && one_way >= 0.5 * compared)) room->settled = 0;
  const bool settling = told && room->settled < k_settling;
  if (told && enough) {
    const double median = median_of(v), usual = median > k_noise ? k_noise : median < -k_noise ? -k_noise : median;
    if (settling) follow_light(room, median - room->usual);
    else room->usual += k_usual_rate * (usual - room->usual);
  }
  return settling || (enough && hidden >= k_half_blind * compared) ? RoomLesson::unknown : RoomLesson::all;
}

}  // namespace

bool room_remembers(const RoomPart& part) {
  return room_memory(part.age) * static_cast<double>(part.seen) >= k_memory &&
         static_cast<double>(part.clipped) <= k_memory_clipped && luminance(part.radiance) > 0;
}

double room_part_weight(uint32_t part) {
  const uint32_t row = part / k_room_columns;
  return sin_cos_turns((row + 0.5) / (2 * k_room_rows)).sin;
}

void room_vote(Room* room, uint32_t index, double area, const RoomObservation& now) {
  RoomVote* v = &room->view.vote;
  const double weight = area * now.covered, shown = luminance(now.colour);
  add(&v->area, weight);
  add(&v->shown, weight * shown);
  const bool black = !(shown > k_black);
  if (black) add(&v->black, weight);
  const RoomPart& part = room->parts[index];
  if (now.covered < 1 || !room_remembers(part)) return;
  const double to_image = room->light / room->view.scale, expected = luminance(part.radiance) * to_image;
  const bool told = room->exposure_known && room->view.image.exposure > 0;
  if (told && expected < k_dim && shown < k_dim) return;
  if (now.clipped > 0 || black) {
    // Where the exposure is not told, what is clipped says only that it is.
    const bool hides = black ? expected >= k_dim : now.clipped >= k_white_from && expected < 0.9;
    if (!hides) return;
    const double ratio = black ? logarithm_of(k_black) - logarithm_of(expected) : -logarithm_of(expected);
    add(black ? &v->darker : &v->brighter, weight);
    add(black ? &v->darker_sum : &v->brighter_sum, weight * ratio);
    if (absolute(ratio) > k_change) add(black ? &v->less : &v->more, weight);
    return;
  }
  const double known = logarithm_of(expected), ratio = logarithm_of(shown) - known;
  const double at = (ratio - k_lowest) / k_bin;
  const int64_t bin = floor_index(at < 0 ? 0 : at < k_vote_bins - 1 ? at : k_vote_bins - 1);
  add(&v->weight[bin], weight);
  add(&v->sum[bin], weight * ratio);
  add(&v->exact, weight);
  if (ratio > k_change) add(&v->more, weight);
  if (ratio < -k_change) add(&v->less, weight);
  add(&v->known, weight * known);
  add(&v->known_squared, weight * known * known);
  add(&v->error, weight * ratio);
  add(&v->error_squared, weight * ratio * ratio);
  for (int c = 0; c < 3; ++c) {
    add(&v->now[c], weight * now.colour[c]);
    add(&v->then[c], weight * static_cast<double>(part.radiance[c]));
  }
}

bool room_is_steady(const Room& room) {
  return room.exposure_known && room.settled >= k_settling && !(room.doubted > 0);
}

void room_decide(Room* room) {
  RoomView* view = &room->view;
  const double exposure = static_cast<double>(view->image.exposure);
  const bool first_told = exposure > 0 && !room->exposure_known, told = exposure > 0 && !first_told;
  const double found = found_scale(*room);
  view->lesson = lesson_of(room, told);
  if (view->lesson == RoomLesson::nothing) return;
  // Where it is missing once, the exposure is nearly that of the image before.
  const double apart = logarithm(found / room->scale);
  const bool once = room->exposure_known && absolute(apart) < k_noise;
  if (!told) view->scale = once ? room->scale * exponential(k_missing_rate * apart) : found;
  if (first_told) {
    // What was seen until now was in units of the first image's white. From now on it is in the app's.
    const double factor = room->images != 0 ? 1 / (exposure * found) : 1;
    const auto turn = [factor](float radiance[3]) {
      for (int c = 0; c < 3; ++c) radiance[c] = room_bounded_radiance(static_cast<double>(radiance[c]) * factor);
    };
    for (RoomPart& part : room->parts) turn(part.radiance);
    for (uint32_t i = 0; room->texels != nullptr && i < k_cube_texels; ++i) turn(room->texels[i].radiance);
    room->scale = bounded(room->scale * factor);
    room->exposure_known = true;
    room->unit += room->images != 0 ? 1 : 0;
    view->scale = bounded(1 / exposure);
  }
}

}  // namespace sandglass

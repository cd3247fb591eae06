// What an image says of its exposure, and of the light of the whole room.
//
// Each part that is remembered and shown again votes with the ratio of what the image shows to what is remembered. The
// weighted median of the votes is how much brighter the image is. A clipped part is only known to be at least as bright
// as it is shown: it counts as those votes do that say more. A black one stands at the lower end. With known exposures
// the median is a change of the room's light; else it is the exposure.
//
// The light of the whole room is one factor beside its parts. So what is out of the picture follows at once, and a change
// and its return cancel. For some time after a change the parts themselves are left alone, while the factor follows each
// image. Light that returns to what it was is believed at once. What no change of light explains, a finger over the
// lens, is not believed for a while; nor is what a few parts say, until they have said it for as long. What is black or
// clipped almost everywhere teaches nothing.
#include "kernels/whole.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/room.h"
#include "runtime/math/math.h"

namespace sandglass {

namespace {

constexpr double k_bin = 0.25, k_lowest = -0.5 * k_bin * k_vote_bins;  // of ratios
constexpr double k_memory = 0.3, k_memory_clipped = 0.01;
// Share of a part that an image has to show: one of nine points may lie beyond its rim.
constexpr double k_compared = 0.8;
// Linear values. Black is one step of a byte: an image that is exposed for a 64th shows little more of a wall. What is
// darker than `dim` says nothing of a change, because bytes round it; unless it was or is brighter.
constexpr double k_black = 0.00031, k_dim = 0.01, k_white_from = 0.5;
// Weights of compared parts, at least: for a scale, for a doubt, for a change.
constexpr double k_scale_weight_min = 1.0, k_doubt_weight_min = 3.0, k_change_weight_min = 8.0;
// The light of the whole room has changed where two thirds of what is seen again are brighter or darker by half.
constexpr double k_change = 0.405, k_change_share = 0.65, k_perhaps_share = 0.35, k_few_share = 0.9;
// A doubt lasts while so much differs: half a finger hides less of a room that becomes brighter.
constexpr double k_still_share = 0.15;
// It has changed, too, where as many parts are brighter or darker by a quarter, and their ratios deviate from the
// median by no more than 0.4 of it. In a change that a seventh of the parts does not share, they deviate by 0.35.
constexpr double k_slight = 0.223, k_alike = 0.4, k_near = 0.5;
constexpr double k_blind = 0.8, k_half_blind = 0.5, k_all_black = 0.98;
// A change of light keeps most of the pattern of what is seen, and its hue: daylight and a warm bulb differ by factors
// of 1.6 in red and 2.7 in blue. A thing before the lens keeps neither.
constexpr double k_pattern_min = 0.05, k_pattern_lost = 0.75, k_other_red = 0.7, k_other_blue = 1.2;
constexpr double k_noise = 0.3, k_usual_rate = 0.1, k_missing_rate = 0.3;
constexpr double k_short_ratio = 3.0;  // an image so much darker is a short one: bytes have lost its pattern
constexpr double k_patience = 2.5, k_settling = 3.0;  // seconds
// A strange image whose logarithms vary by so much shows another room, or another part of it: a finger, a cloth and a
// glare are even. Where the camera has left the sphere it is another room, and half a second of it is enough.
constexpr double k_detail = 0.05, k_patience_far = 0.5;
constexpr double k_far_off = 1.1;     // of logarithms: three times the light, or a third
constexpr double k_shows_rate = 0.2;  // of a new image in the mean of what such images show
constexpr double k_scale_max = 1e6;
// An unknown exposure is expected to change again by this share of its last change. A deviation from that counts as far
// as it exceeds the noise: of a vote of weight 1, and of exposures from image to image (variances). It counts wholly
// where it is five times the noise and three quarters of the votes agree.
constexpr double k_goes_on = 0.82, k_step_noise = 0.1, k_step_usual = 0.0016, k_surely = 25, k_step_alike = 0.75;
// What is remembered corrects the exposure by so much in an image, and by half of what a difference exceeds 0.4 by.
constexpr double k_unseen_step = 0.015, k_far_difference = 0.4, k_far_rate = 0.5;
// While nothing is learned, a greater step is not one of the camera's exposure: where what is remembered agrees with
// the step; in an image that is strange; in others.
constexpr double k_adapts_surely = 1, k_adapts_strange = 0.12, k_adapts = 0.25;
// White balance. Darker channels have no hue, because bytes round them. A part whose hue differs by k_other_hue counts
// a quarter; one that is as uneven as k_uneven counts half, because nine points say little of it. The noise is the
// variance of a vote of weight 1.
constexpr double k_hue_from = 0.01, k_other_hue = 0.35, k_uneven = 0.1, k_hue_noise = 4e-4;
constexpr double k_hues_weight_min = 4.0;  // weight of parts
constexpr double k_balance_max = 16.0;     // of a channel, beside the first image

double bounded(double x) { return x < 1 / k_scale_max ? 1 / k_scale_max : x > k_scale_max ? k_scale_max : x; }

void add(float* sum, double value) { *sum += static_cast<float>(value); }

// Out of line: it is called from many places, and long.
__attribute__((noinline)) double logarithm_of(double x) { return logarithm(x > 0.5 * k_black ? x : 0.5 * k_black); }

int64_t bin_of(double ratio) {
  const double at = (ratio - k_lowest) / k_bin;
  return floor_index(at < 0 ? 0 : at < k_vote_bins - 1 ? at : k_vote_bins - 1);
}

void add_ratio(RoomRatios* ratios, double weight, double ratio) {
  const int64_t bin = bin_of(ratio);
  add(&ratios->weight[bin], weight);
  add(&ratios->sum[bin], weight * ratio);
}

double weight_of(const RoomRatios& ratios) {
  double sum = 0;
  for (const float w : ratios.weight) sum += static_cast<double>(w);
  return sum;
}

// The ratio below which lies so much weight: the mean of the votes in the bins about it. 0: there is less weight.
// `near`: the weight of these votes. `at_least`: the weight of those that stand in a bin or above it. Their weight goes
// to the votes above, in proportion (Kaplan and Meier, 1958).
double ratio_above(const RoomRatios& ratios, double weight_below, double* near, const float* at_least) {
  double below = 0, share = 1, rest = weight_of(ratios);
  for (uint32_t i = 0; i < k_vote_bins; ++i) rest += at_least != nullptr ? static_cast<double>(at_least[i]) : 0;
  for (uint32_t i = 0; i < k_vote_bins; ++i) {
    below += share * static_cast<double>(ratios.weight[i]);
    rest -= static_cast<double>(ratios.weight[i]);
    const double above = at_least != nullptr ? rest - static_cast<double>(at_least[i]) : rest;
    if (above > 0) share *= rest / above;
    rest = above;
    if (!(ratios.weight[i] > 0) || below < weight_below) continue;
    double weight = 0, sum = 0;
    for (uint32_t k = i > 0 ? i - 1 : 0; k <= i + 1 && k < k_vote_bins; ++k) {
      weight += static_cast<double>(ratios.weight[k]);
      sum += static_cast<double>(ratios.sum[k]);
    }
    if (near != nullptr) *near = weight;
    return sum / weight;
  }
  return 0;
}

// The median, at the mean of the votes about it.
double median_of(const RoomVote& v) {
  const auto brighter = static_cast<double>(v.brighter), darker = static_cast<double>(v.darker),
             exact = weight_of(v.ratios);
  const double half = 0.5 * (brighter + darker + exact);
  if (darker > 0 && darker >= half) return static_cast<double>(v.darker_sum / v.darker);
  const double median = ratio_above(v.ratios, half - darker, nullptr, v.at_least);
  return median != 0 || !(brighter > 0) ? median : static_cast<double>(v.brighter_sum / v.brighter);
}

// The variance over the parts whose ratio is known exactly, of a sum and a sum of squares of RoomVote.
double variance(const RoomVote& v, float sum, float squares) {
  const double mean = static_cast<double>(sum / v.exact);
  return static_cast<double>(squares / v.exact) - mean * mean;
}

// Whether the image shows something else than the room in another light. In an image that is so much darker, bytes have
// lost the pattern. If its exposure is known and not short, that is strange.
bool is_strange(const RoomVote& v, bool exposure_known) {
  const auto exact = static_cast<double>(v.exact);
  if (absolute(median_of(v)) > k_short_ratio) return exposure_known;
  if (exact < k_change_weight_min) return false;
  double hue[3];
  for (int c = 0; c < 3; ++c)
    hue[c] = logarithm_of(static_cast<double>(v.now[c])) - logarithm_of(static_cast<double>(v.then[c]));
  const double red = hue[0] - hue[1], blue = hue[2] - hue[1];
  if (absolute(red) > k_other_red || absolute(blue) > k_other_blue) return true;
  const double pattern = variance(v, v.known, v.known_squared);
  return pattern > k_pattern_min && variance(v, v.error, v.error_squared) > k_pattern_lost * pattern;
}

// The scale of an image whose exposure is not known. Parts that the image before showed as well say how the exposure
// changed. What is remembered says what it should be, and is approached in steps that nobody sees.
double found_scale(Room* room) {
  const RoomVote& v = room->view.vote;
  const double compared = weight_of(v.steps);
  const bool steps = compared >= k_scale_weight_min, remembers = static_cast<double>(v.exact) >= k_scale_weight_min;
  double by_step = k_goes_on * static_cast<double>(room->brightens);
  bool alike = false;
  if (steps) {
    double near = 0;
    const double beside = -ratio_above(v.steps, 0.5 * compared, &near, nullptr) - by_step,
                 noise = k_step_noise / compared;
    alike = near >= k_step_alike * compared;
    const bool surely = alike && beside * beside > k_surely * noise;
    by_step += (surely ? 1 : k_step_usual / (k_step_usual + noise)) * beside;
  }
  const double by_memory = remembers ? logarithm(room->scale / room->shown_scale) - median_of(v) : by_step,
               difference = by_memory - by_step;
  const double beyond = absolute(difference) - k_far_difference;
  const double slowly = k_unseen_step + (beyond > 0 ? k_far_rate * beyond : 0);
  const bool tells = beyond > 0 && !alike && static_cast<double>(v.exact) >= k_change_weight_min;
  const double limit = tells ? absolute(difference) : slowly;
  const double change = by_step + (difference < -limit ? -limit : difference > limit ? limit : difference);
  room->view.steps_agree = alike && remembers && beyond <= 0;
  room->brightens = static_cast<float>(steps ? by_step : 0);
  return bounded(room->shown_scale * exponential(change));
}

// While the light settles, the room's factor follows each image. A change that most parts do not agree on may be noise
// of which parts vote: then the factor follows the mean of the images. So it does in a doubt, or only one sign would
// count.
void follow_light(Room* room, double change, bool surely) {
  const double step = room->view.step, rate = step > 0 ? 2 * step / (room->settled + 2 * step) : 1;
  room->light = bounded(room->light * exponential(surely && absolute(change) > k_noise ? change : rate * change));
}

// Whether an image that differs shows the room in the light that it was in before the last change. Light that returns
// is known, so it is believed at once, however much brighter or darker it is.
bool returns(const Room& room, double median) {
  const double back = logarithm(room.light_before / room.light);
  return absolute(back) > k_noise && absolute(median - back) < 0.5 * absolute(back);
}

// Whether most of what is compared has changed alike, even if by less than a half. Ratios far from the median, as of
// what half a finger hides, do not count.
bool all_alike(const Room& room, double median, double hidden) {
  const RoomVote& v = room.view.vote;
  const auto exact = static_cast<double>(v.exact);
  if (exact < k_change_weight_min) return false;
  double near = 0, sum = 0, squares = 0;
  for (uint32_t i = 0; i < k_vote_bins; ++i) {
    const auto weight = static_cast<double>(v.ratios.weight[i]),
               mean = weight > 0 ? static_cast<double>(v.ratios.sum[i]) / weight : 0;
    if (!(weight > 0) || absolute(mean - median) > k_near) continue;
    near += weight;
    sum += weight * mean;
    squares += weight * (mean * mean + k_bin * k_bin / 12);  // within a bin they are spread evenly
  }
  if (near < k_change_share * (exact + hidden)) return false;
  const double mean = sum / near, change = median - room.usual;
  return absolute(change) > k_slight && squares / near - mean * mean < k_alike * k_alike * change * change;
}

// Whether the camera is beyond where the walls were taken to be.
bool is_beyond(const Room& room) {
  const double metres = room_first_radius(room) / room.radius, *at = room.view.position;
  return room.grown > 0 || (room.far && at[0] * at[0] + at[1] * at[1] + at[2] * at[2] > metres * metres);
}

// Whether an image that is strange has a room's detail.
bool is_detailed(const RoomVote& v) { return variance(v, v.known + v.error, v.shown_squared) > k_detail; }

// The image seems to show another room: remembers how bright that is.
void look_through_door(Room* room) {
  const RoomVote& v = room->view.vote;
  if (!(room->shows > 0) && !is_beyond(*room) && !is_detailed(v)) return;
  const double shows = bounded(room->view.scale * static_cast<double>(v.shown / v.area));
  room->shows = room->shows > 0 ? room->shows * exponential(k_shows_rate * logarithm(shows / room->shows)) : shows;
}

// A doubt of the other sign begins anew: a flash after a finger.
void doubt(Room* room, double median) {
  const bool other = median * room->doubts < 0 && absolute(median) > k_change && absolute(room->doubts) > k_change;
  room->doubted = (other ? 0 : room->doubted) + room->view.step;
  room->doubts = median;
}

void begin_to_settle(Room* room, bool back) {
  if (back || !(room->settled < k_settling)) room->light_before = room->light;
  room->settled = room->shows = 0;
}

// How much brighter an image shows a part than the image before. Bytes round what is dark.
void vote_of_step(Room* room, uint32_t index, double weight, const RoomObservation& now) {
  RoomPart* part = &room->parts[index];
  const RoomView& view = room->view;
  const double shown = luminance(now.colour);
  const int before = view.shows_steps && part->shown != k_shown_anew ? part->shown : 0;
  part->shown = 0;
  if (now.covered < 1 || now.clipped > 0) return;
  const double octaves = logarithm(shown > k_dim ? shown : k_dim) / 0.6931471805599453;
  if (shown > k_dim) part->shown = to_whole<uint8_t>(octaves < 0 ? 255.5 + 16 * octaves : 255);
  if (before == 0) return;
  const double step = 0.6931471805599453 * (octaves - (before - 255) / 16.0);
  if (shown > k_dim) add_ratio(&room->view.vote.steps, weight, step);
  if (!room->exposure_known || !(view.image.exposure > 0)) return;
  // What is dim, as in a short image, is no brighter than this.
  const double change = step + logarithm(view.scale / room->shown_scale);
  if (change < -k_change || (shown > k_dim && change > k_change)) part->shown = k_shown_anew;
}

// How much redder and bluer an image shows a part than it is remembered. Bright, even parts tell it best.
void vote_of_hue(RoomVote* v, const RoomPart& part, const RoomObservation& now, double weight) {
  double became[3];
  for (int c = 0; c < 3; ++c) {
    const auto known = static_cast<double>(part.radiance[c]);
    if (!(now.colour[c] > k_hue_from) || !(known > 0)) return;
    became[c] = now.colour[c] / known;
  }
  const double red = logarithm(became[0] / became[1]), blue = logarithm(became[2] / became[1]);
  const double other = (red * red + blue * blue) / (k_other_hue * k_other_hue);
  const double counts = weight * luminance(now.colour) / ((1 + other) * (1 + other) * (1 + now.uneven / k_uneven));
  add(&v->hues, weight);
  add(&v->hue, counts);
  add(&v->red, counts * red);
  add(&v->blue, counts * blue);
}

// Unknown white balance moves as the mean of the votes, as far as that is more than noise; not with the light,
// and so that grey stays as bright.
void follow_balance(Room* room) {
  RoomView* view = &room->view;
  const RoomVote& v = view->vote;
  if (room_knows_gains(*room, view->image)) return;
  const bool settled = !(room->settled < k_settling) && !(room->doubted > 0);
  if (settled && static_cast<double>(v.hues) >= k_hues_weight_min) {
    const auto red = static_cast<double>(v.red / v.hue), blue = static_cast<double>(v.blue / v.hue);
    const double squared = red * red + blue * blue,
                 rate = squared / (squared + k_hue_noise / static_cast<double>(v.hue));
    const auto move = [rate](float* balance, double by) {
      const double to = static_cast<double>(*balance) * exponential(rate * by);
      *balance = static_cast<float>(to < 1 / k_balance_max ? 1 / k_balance_max
                                    : to < k_balance_max   ? to
                                                           : k_balance_max);
    };
    move(&view->balance[0], red);
    move(&view->balance[2], blue);
    const double balance[3] = {static_cast<double>(view->balance[0]), static_cast<double>(view->balance[1]),
                               static_cast<double>(view->balance[2])};
    for (int c = 0; c < 3; ++c) view->balance[c] = static_cast<float>(balance[c] / luminance(balance));
  }
  if (view->image.gains[1] > 0)
    for (int c = 0; c < 3; ++c) room->gains[c] = view->image.gains[c] / view->balance[c];
}

RoomLesson lesson_of(Room* room, bool exposure_known) {
  const RoomVote& v = room->view.vote;
  // A short image for lamps: what it shows of their parts at a few points says nothing of the light of the room. One
  // that shows more goes on with a doubt.
  if (room_shows_lamps_only(*room) || (room_is_short(*room) && !(room->doubted > 0)))
    return room->doubted > 0 || room->settled < k_settling ? RoomLesson::unknown : RoomLesson::all;
  const double hidden = static_cast<double>(v.white) + static_cast<double>(v.darker);
  const double compared = static_cast<double>(v.exact + v.brighter + v.darker), median = median_of(v);
  const bool enough = compared >= k_change_weight_min;
  const bool black = static_cast<double>(v.black) >= k_all_black * static_cast<double>(v.area);
  if (black || (enough && hidden >= k_blind * compared)) {
    doubt(room, median);
    return RoomLesson::nothing;
  }
  // An image of which little can be compared, such as a short one, neither begins nor ends a doubt. While the exposure
  // returns from what covered the lens, an image shows little at first: that must not be learned before the rest can
  // say why it differs.
  const bool compares = compared >= k_doubt_weight_min;
  const double one_sided = static_cast<double>(v.more > v.less ? v.more : v.less);
  const bool back = exposure_known && compares && returns(*room, median);
  const bool alike = exposure_known && !(room->settled < k_settling) && all_alike(*room, median, hidden);
  const bool still = room->doubted > 0 && static_cast<double>(v.more + v.less) >= k_still_share * compared;
  const bool perhaps = alike || (exposure_known && compared > 0 && (still || one_sided >= k_perhaps_share * compared));
  const bool clear = hidden <= (1 - k_blind) * compared;
  const bool strange = !back && clear && (perhaps || !exposure_known) && is_strange(v, exposure_known && enough);
  const bool surely = back || (exposure_known && enough && (alike || one_sided >= k_change_share * compared));
  const bool all_few = compares && one_sided >= k_few_share * compared;
  // A doubt goes on while much is hidden, even if the rest agrees: else it would never end.
  const bool doubts = room->doubted > 0, half_blind = doubts && !clear;
  const bool doubtful = strange || (perhaps && (!surely || half_blind) && (enough || all_few || doubts));
  if (doubtful && compares) doubt(room, median);
  else if (enough && clear) room->doubted = room->shows = 0;
  // One strange image alone may be a short one for lamps. While the camera is in the room, it shows another room only
  // if it is much darker or brighter, too.
  const bool far_off = is_beyond(*room) || absolute(median - room->usual) > k_far_off;
  if (!far_off) room->shows = 0;
  if (strange && room->strange && far_off) look_through_door(room);
  room->strange = strange;
  if (!doubtful && room->doubted > 0) return RoomLesson::unknown;
  const bool other = strange && is_beyond(*room) && is_detailed(v);
  if (doubtful && room->doubted < (other ? k_patience_far : k_patience)) {
    if (exposure_known && !strange && room->settled < k_settling) follow_light(room, median - room->usual, false);
    return strange ? RoomLesson::nothing : RoomLesson::unknown;
  }
  if (other) {
    room_leave(room);
    return RoomLesson::all;
  }
  const double change = back ? logarithm(room->light_before / room->light) : median - room->usual;
  // After so long a doubt, half of the parts are enough.
  if (surely || (doubtful && (alike || one_sided >= 0.5 * compared))) begin_to_settle(room, back);
  const bool settling = exposure_known && room->settled < k_settling;
  if (exposure_known && compares) {
    const double usual = median > k_noise ? k_noise : median < -k_noise ? -k_noise : median;
    if (settling) follow_light(room, change, surely);
    else if (enough && !doubtful) room->usual += k_usual_rate * (usual - room->usual);
  }
  return settling || (enough && hidden >= k_half_blind * compared) ? RoomLesson::unknown : RoomLesson::all;
}

}  // namespace

bool room_remembers(const RoomPart& part) {
  return room_memory(part.age) * part.seen >= k_memory && part.clipped <= k_memory_clipped &&
         luminance(part.radiance) > 0;
}

double room_part_weight(uint32_t part) {
  const uint32_t row = part / k_room_columns;
  return sin_cos_turns((row + 0.5) / (2 * k_room_rows)).sin;
}

void room_vote(Room* room, uint32_t index, double area, const RoomObservation& now) {
  RoomVote* v = &room->view.vote;
  const double weight = area * now.covered, shown = luminance(now.colour);
  vote_of_step(room, index, weight, now);
  add(&v->area, weight);
  add(&v->shown, weight * shown);
  const bool black = !(shown > k_black);
  if (black) add(&v->black, weight);
  const RoomPart& part = room->parts[index];
  if (now.covered < k_compared || !room_remembers(part)) return;
  const double to_image = room->light / room->view.scale, expected = luminance(part.radiance) * to_image;
  const bool exposure_known = room->exposure_known && room->view.image.exposure > 0;
  if (!black && !(now.clipped > 0)) vote_of_hue(v, part, now, weight);
  if (exposure_known && expected < k_dim && shown < k_dim) return;
  if (now.clipped > 0 || black) {
    // Where the exposure is not known, what is clipped says only that it is.
    const bool hides = black ? expected >= k_dim : expected < 0.9;
    if (!hides) return;
    const double ratio = logarithm_of(black ? k_black : shown) - logarithm_of(expected);
    // One that is clipped by less than half says something where it shows a change. Its nine points show too much by
    // chance, where they differ: by a standard deviation of their mean.
    const bool partly = !black && now.clipped < k_white_from;
    if (partly && !(ratio - square_root(now.uneven) / 3 > k_change)) return;
    if (!black) add(&v->at_least[bin_of(ratio)], weight);
    if (!black && now.clipped >= k_white_from) add(&v->white, weight);
    add(black ? &v->darker : &v->brighter, weight);
    add(black ? &v->darker_sum : &v->brighter_sum, weight * ratio);
    if (absolute(ratio) > k_change) add(black ? &v->less : &v->more, weight);
    return;
  }
  const double known = logarithm_of(expected), ratio = logarithm_of(shown) - known;
  add_ratio(&v->ratios, weight, ratio);
  add(&v->exact, weight);
  if (ratio > k_change) add(&v->more, weight);
  if (ratio < -k_change) add(&v->less, weight);
  add(&v->known, weight * known);
  add(&v->known_squared, weight * known * known);
  add(&v->error, weight * ratio);
  add(&v->error_squared, weight * ratio * ratio);
  add(&v->shown_squared, weight * (known + ratio) * (known + ratio));
  for (int c = 0; c < 3; ++c) {
    add(&v->now[c], weight * now.colour[c]);
    add(&v->then[c], weight * static_cast<double>(part.radiance[c]));
  }
}

void room_decide(Room* room) {
  RoomView* view = &room->view;
  const double exposure = static_cast<double>(view->image.exposure);
  const bool first_exposure = exposure > 0 && !room->exposure_known, exposure_known = exposure > 0 && !first_exposure;
  const double found = exposure_known ? room->scale : found_scale(room);
  room->shown_scale = exposure_known ? view->scale : found;
  room->shows_steps = true;
  view->lesson = lesson_of(room, exposure_known);
  if (view->lesson == RoomLesson::nothing) {
    // What covers the lens comes and goes at once; the camera adapts to it slowly.
    if (exposure_known || room->exposure_known) return;
    const double limit = view->steps_agree ? k_adapts_surely : room->strange ? k_adapts_strange : k_adapts;
    if (absolute(static_cast<double>(room->brightens)) > limit) room->brightens = 0;
    room->scale = room->shown_scale = bounded(room->scale * exponential(static_cast<double>(room->brightens)));
    return;
  }
  follow_balance(room);
  // Where it is missing once, the exposure is nearly that of the image before.
  const double difference = logarithm(found / room->scale);
  const bool once = room->exposure_known && absolute(difference) < k_noise;
  if (!exposure_known) view->scale = once ? room->scale * exponential(k_missing_rate * difference) : found;
  if (first_exposure) {
    // What was seen until now was in units of the first image's white. From now on it is in the app's.
    const double factor = room->images != 0 ? 1 / (exposure * found) : 1;
    const auto turn = [factor](float radiance[3]) {
      for (int c = 0; c < 3; ++c) radiance[c] = room_bounded_radiance(static_cast<double>(radiance[c]) * factor);
    };
    for (RoomPart& part : room->parts) turn(part.radiance);
    for (uint32_t i = 0; room->texels != nullptr && i < k_cube_texels; ++i) turn(room->texels[i].radiance);
    room->scale = bounded(room->scale * factor);
    room->shown_scale = bounded(1 / exposure);
    room->exposure_known = true;
    room->unit += room->images != 0 ? 1 : 0;
    view->scale = bounded(1 / exposure);
  }
}

}  // namespace sandglass

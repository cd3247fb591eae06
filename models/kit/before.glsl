// How far something real stands before what is drawn, metres. `real` and `drawn` are their depths along the camera's axis; `eye` and
// `height` are those of the eye and of what is drawn over a plane, along its normal. What is real and lies on the plane, up to
// `bias`, by which depth may be wrong, is the plane. It hides from `bias` on, wholly from 2 * bias; where the eye is low, wholly
// from half the way on. Seen from below nothing lies on the plane, and the depths alone count.
float sandglass_before(float real, float drawn, float eye, float height, float bias) {
  return eye > 0.0 ? min(drawn - real, mix(eye, height, real / drawn) * max(1.0, 4.0 * bias / eye)) : drawn - real;
}

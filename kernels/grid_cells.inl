// The cell of each particle or grain in a wrapped grid. Coordinates are clamped before the cast, because casts out of
// range differ between machines.

SANDGLASS_INLINE Int floor_to_int(Float a) {
  return floor_int(minimum(maximum(a, broadcast(-536870912.0f)), broadcast(536870912.0f)));
}

static void grid_cells(const GridCellsArgs* args, uint32_t begin, uint32_t end, uint32_t* result) {
  (void)result;
  const Grid& grid = args->grid;
  const Float inverse = broadcast(grid.inverse_cell);
  const Int mask_x = broadcast(static_cast<int32_t>((1u << grid.bits[0]) - 1));
  const Int mask_y = broadcast(static_cast<int32_t>((1u << grid.bits[1]) - 1));
  const Int mask_z = broadcast(static_cast<int32_t>((1u << grid.bits[2]) - 1));
  const int shift_y = static_cast<int>(grid.bits[0]), shift_z = static_cast<int>(grid.bits[0] + grid.bits[1]);
  for (uint32_t i = begin; i < end; i += k_width) {
    Float record[k_record_floats];
    load_records(floats_of(args->records + i), record);
    Int x = floor_to_int(record[k_x] * inverse), y = floor_to_int(record[k_y] * inverse),
        z = floor_to_int(record[k_z] * inverse);
    if (args->serpentine != 0) {
      z = (z - broadcast(args->first[2])) & mask_z;
      y = (y - broadcast(args->first[1])) & mask_y;
      x = (x - broadcast(args->first[0])) & mask_x;
      y = select((z & broadcast(1)) == broadcast(1), mask_y - y, y);
      x = select((y & broadcast(1)) == broadcast(1), mask_x - x, x);
    }
    x = x & mask_x;
    y = y & mask_y;
    z = z & mask_z;
    store(args->keys + i, x | shift_left(y, shift_y) | shift_left(z, shift_z));
  }
}

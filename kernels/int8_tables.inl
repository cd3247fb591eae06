// The tables of one instruction set: one with all kernels, and one for each capability, so that an app links only the
// kernels it uses.
extern const Int8Kernels k_table, k_shadow_table, k_light_table;
const Int8Kernels k_table = {SANDGLASS_INT8_ISA, pack_layer, shadow_texels, ambient_texels, narrow,
                             transition,         wide,       stem,          pool,           dot};
const Int8Kernels k_shadow_table = {SANDGLASS_INT8_ISA,
                                    pack_layer,
                                    shadow_texels,
                                    ambient_texels,
                                    nullptr,
                                    nullptr,
                                    nullptr,
                                    nullptr,
                                    nullptr,
                                    nullptr};
const Int8Kernels k_light_table = {SANDGLASS_INT8_ISA, pack_layer, nullptr, nullptr, narrow,
                                   transition,         wide,       stem,    pool,    dot};

// From the trained network, in float, to the bytes that the runtime reads.
//
// WEIGHTS.npz holds the trunk by the names and shapes of the pretrained file (kernels row, column, input, output):
//   conv1/conv/kernel, conv1/bn/{gamma,beta,moving_mean,moving_variance},
//   conv{2..5}_block{l}_{0_bn,1_conv,1_bn,2_conv}/…, pool{2..4}_{bn,conv}/…, bn/…
// and the heads by these:
//   latent/kernel 1024 x 512, latent/bias 512, latent/bn/{gamma,beta,moving_mean,moving_variance} 512 (epsilon 1e-5),
//   direction/kernel 512 x 3, light/kernel 512 x 3, ambient/kernel 512 x 3, contrast/kernel 512 x 1, and their /bias;
// optionally data_hash (16 hexadecimal digits as 16 uint8 characters), seed and training_images (one number each).
#pragma once

#include <gpsrecon/hem/hem.h>

#include <cstdio>

int main() {
  gpsrecon::PointCloud cloud;
  for (int i = 0; i < 400; ++i) cloud.positions.emplace_back(i % 20, i / 20, 0);
  gpsrecon::HemOptions options;
  options.sigma0 = 1;
  const gpsrecon::Mixture mixture = gpsrecon::build_mixture(cloud, options);
  std::printf("%zu points became %zu Gaussians\n", cloud.size(), mixture.size());
  return mixture.empty() || mixture.size() == cloud.size() ? 1 : 0;
}

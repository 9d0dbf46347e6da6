/// Speed of the compression of points, for the point formats of airborne strips.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <sstream>
#include <string>

#include "laz/laz.h"
#include "testing/laz_records.h"

namespace dn {
namespace {

namespace laz = lidar_internal::laz;

constexpr std::size_t kPoints = 200000;

std::string Compress(const laz::Compression& compression, const std::string& records) {
  laz::PointWriter writer(compression, 0);
  writer.Append(records);
  writer.Finish();
  std::string file = writer.TakeBytes();
  testing::LasBytes::Put(writer.table_at(), 0, &file);
  return file;
}

/// Arguments: the point format and the number of extra bytes.
void BM_Read(benchmark::State& state) {
  const testing::LazRecords records(static_cast<int>(state.range(0)),
                                    static_cast<std::size_t>(state.range(1)), kPoints, 1);
  const laz::Compression compression =
      laz::MakeCompression(static_cast<int>(state.range(0)), records.record_bytes());
  std::istringstream in(Compress(compression, records.bytes()));
  std::string read(records.bytes().size(), '\0');
  for (auto _ : state) {
    const laz::CompressedPoints points =
        laz::FindChunks(&in, compression, 0, in.view().size(), kPoints);
    laz::PointReader(&in, &points).Read(kPoints, records.record_bytes(), read.data());
  }
  if (read != records.bytes()) state.SkipWithError("the points differ");
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPoints));
}

void BM_Write(benchmark::State& state) {
  const testing::LazRecords records(static_cast<int>(state.range(0)),
                                    static_cast<std::size_t>(state.range(1)), kPoints, 1);
  const laz::Compression compression =
      laz::MakeCompression(static_cast<int>(state.range(0)), records.record_bytes());
  std::size_t bytes = 0;
  for (auto _ : state) bytes = Compress(compression, records.bytes()).size();
  state.counters["share"] =
      static_cast<double>(bytes) / static_cast<double>(records.bytes().size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPoints));
}

void Formats(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"format", "extra"});
  for (const int format : {1, 3, 6, 7}) bench->Args({format, 0});
  bench->Args({6, 24});
  bench->Unit(benchmark::kMillisecond);
}

BENCHMARK(BM_Read)->Apply(Formats);
BENCHMARK(BM_Write)->Apply(Formats);

}  // namespace
}  // namespace dn

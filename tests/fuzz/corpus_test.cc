#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "read_anything.h"

namespace dn::testing::corpus_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

struct Input {
  std::string name;
  std::string bytes;
};

/// Returns the corpus. Names start with ok_ if the reader accepts the input, or with bad_ if it
/// rejects the input.
std::vector<Input> Corpus() {
  std::vector<Input> corpus;
  for (const fs::directory_entry& entry : fs::directory_iterator(DN_FUZZ_CORPUS)) {
    std::ifstream in(entry.path(), std::ios::binary);
    corpus.push_back({entry.path().filename().string(),
                      {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()}});
  }
  std::sort(corpus.begin(), corpus.end(),
            [](const Input& a, const Input& b) { return a.name < b.name; });
  return corpus;
}

/// Returns the message of the rejection; empty if the input is accepted. Any other exception fails
/// the test.
std::string Read(const std::string& bytes) {
  return ReadAnything(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
}

TEST(ReaderCorpus, HoldsAnAcceptedAndARejectedInputForEveryReader) {
  std::set<char> accepted, rejected;
  for (const Input& input : Corpus()) {
    SCOPED_TRACE(input.name);
    const std::string message = Read(input.bytes);
    if (input.name.starts_with("ok_")) {
      EXPECT_EQ(message, "");
      accepted.insert(input.bytes.at(0));
    } else {
      EXPECT_NE(message, "");
      rejected.insert(input.bytes.at(0));
    }
  }
  const std::set<char> all(kReaders.begin(), kReaders.end());
  EXPECT_EQ(accepted, all);
  EXPECT_EQ(rejected, all);
}

TEST(ReaderCorpus, AnEmptyFileIsRejectedByEveryReaderOfData) {
  for (const char reader : kReaders) {
    if (reader == 'F') continue;  // every section of flight.yaml may be absent
    SCOPED_TRACE(reader);
    EXPECT_NE(Read(std::string(1, reader)), "");
  }
}

TEST(ReaderCorpus, TruncatedInputsAreReadOrRejected) {
  constexpr std::size_t kCuts = 40;
  for (const Input& input : Corpus()) {
    SCOPED_TRACE(input.name);
    for (std::size_t cut = 0; cut < kCuts; ++cut) {
      const std::size_t length = 1 + cut * (input.bytes.size() - 1) / kCuts;
      EXPECT_NO_THROW(Read(input.bytes.substr(0, length))) << "cut after " << length << " bytes";
    }
  }
}

TEST(ReaderCorpus, MutatedInputsAreReadOrRejected) {
  const std::vector<std::string> insertions = {
      "nan", "inf", "-1e999", ",,", "\r\n", "\n", "#", "~", ": [", "\t", "-", std::string(1, '\0')};
  constexpr int kMutants = 40;
  for (const Input& input : Corpus()) {
    std::mt19937 rng(7);
    for (int mutant = 0; mutant < kMutants; ++mutant) {
      std::string bytes = input.bytes;
      const std::size_t at = 1 + rng() % bytes.size();
      if (mutant % 2 == 0) {
        bytes.insert(std::min(at, bytes.size()), insertions[rng() % insertions.size()]);
      } else if (at < bytes.size()) {
        bytes[at] = static_cast<char>(rng() % 256);
      }
      SCOPED_TRACE(input.name + ", seed 7, mutant " + std::to_string(mutant));
      EXPECT_NO_THROW(Read(bytes));
    }
  }
}

TEST(ReaderCorpus, ANanInATableIsRejectedWithItsPlace) {
  EXPECT_THAT(Read("T1, 2\n3, nan\n"), HasSubstr("nan"));
}

}  // namespace dn::testing::corpus_test

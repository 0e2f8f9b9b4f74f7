#include "server/stream_outbox.h"

#include <gtest/gtest.h>

namespace semmap::server {
namespace {

v1::FrameEstimate Estimate(uint64_t sequence) {
  v1::FrameEstimate estimate;
  estimate.set_sequence(sequence);
  return estimate;
}

// Sequences of the estimates that wait.
std::vector<uint64_t> TakeEstimates(StreamOutbox& outbox) {
  std::vector<uint64_t> sequences;
  v1::StreamFramesResponse response;
  while (outbox.Take(&response)) {
    if (response.has_estimate()) sequences.push_back(response.estimate().sequence());
    response.Clear();
  }
  return sequences;
}

TEST(StreamOutbox, MergesAcknowledgements) {
  StreamOutbox outbox(8);
  outbox.PutAcknowledgement(3);
  outbox.PutAcknowledgement(9);
  outbox.PutAcknowledgement(5);
  v1::StreamFramesResponse response;
  ASSERT_TRUE(outbox.Take(&response));
  EXPECT_EQ(response.acknowledgement().sequence(), 9U);
  EXPECT_FALSE(outbox.Take(&response));
}

TEST(StreamOutbox, RewindBringsBackWhatWasNotAnswered) {
  StreamOutbox outbox(8);
  for (uint64_t sequence = 1; sequence <= 5; ++sequence) outbox.PutEstimate(Estimate(sequence));
  EXPECT_EQ(TakeEstimates(outbox), (std::vector<uint64_t>{1, 2, 3, 4, 5}));
  outbox.PutEstimate(Estimate(6));
  outbox.Rewind(3);
  EXPECT_EQ(TakeEstimates(outbox), (std::vector<uint64_t>{4, 5, 6}));
}

// Sequences from which the corrections that wait hold.
std::vector<uint64_t> TakeCorrections(StreamOutbox& outbox) {
  std::vector<uint64_t> sequences;
  v1::StreamFramesResponse response;
  while (outbox.Take(&response)) {
    if (response.has_correction()) sequences.push_back(response.correction().from_sequence());
    response.Clear();
  }
  return sequences;
}

TEST(StreamOutbox, NewestSetOfCorrectionsReplacesTheLastAndComesAgainAfterABreak) {
  StreamOutbox outbox(8);
  std::vector<v1::MapCorrection> set(3);
  for (uint64_t i = 0; i < set.size(); ++i) set[i].set_from_sequence(i + 1);
  outbox.PutCorrections(set);
  v1::StreamFramesResponse response;
  ASSERT_TRUE(outbox.Take(&response));
  EXPECT_EQ(response.correction().from_sequence(), 1U);
  set.resize(2);
  set[0].set_from_sequence(7);
  set[1].set_from_sequence(9);
  outbox.PutCorrections(set);
  EXPECT_EQ(TakeCorrections(outbox), (std::vector<uint64_t>{7, 9}));
  EXPECT_TRUE(TakeCorrections(outbox).empty());
  outbox.Rewind(0);
  EXPECT_EQ(TakeCorrections(outbox), (std::vector<uint64_t>{7, 9}));
}

TEST(StreamOutbox, KeepsOnlySoManyTakenAnswers) {
  StreamOutbox outbox(2);
  for (uint64_t sequence = 1; sequence <= 5; ++sequence) outbox.PutEstimate(Estimate(sequence));
  TakeEstimates(outbox);
  outbox.Rewind(0);
  EXPECT_EQ(TakeEstimates(outbox), (std::vector<uint64_t>{4, 5}));
}

TEST(StreamOutbox, DroppedFramesAreAnswersInOrder) {
  StreamOutbox outbox(8);
  outbox.PutDropped({}, 0);
  outbox.PutDropped({2, 3}, 2);
  outbox.PutEstimate(Estimate(4));
  v1::StreamFramesResponse response;
  ASSERT_TRUE(outbox.Take(&response));
  EXPECT_EQ(response.dropped().sequences_size(), 2);
  EXPECT_EQ(response.dropped().total(), 2U);
  ASSERT_TRUE(outbox.Take(&response));
  EXPECT_TRUE(response.has_estimate());
}

}  // namespace
}  // namespace semmap::server

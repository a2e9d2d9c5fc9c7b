// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/prompts.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace tsg::language {
namespace {

using Texts = std::vector<std::string>;

std::string messageOf(const Texts& templates) {
  try {
    checkTemplates(templates);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

TEST(PromptTemplates, PromptsOfOneNameAreNeighbours) {
  EXPECT_EQ(fillTemplates({"mug", "two books"}, {"{}", "an image of {}!"}),
            Texts({"mug", "an image of mug!", "two books", "an image of two books!"}));
  EXPECT_EQ(fillTemplates({}, {"{}"}), Texts());
}

TEST(PromptTemplates, NameThatLooksLikeThePlaceholderIsTakenAsItIs) {
  EXPECT_EQ(fillTemplates({"a {} b"}, {"see {}"}), Texts({"see a {} b"}));
}

TEST(PromptTemplates, PlaceholderMustBeThereOnce) {
  EXPECT_EQ(messageOf({"{}", "an image of {}"}), "");
  EXPECT_NE(messageOf({}).find("there is no prompt template"), std::string::npos);
  EXPECT_NE(messageOf({"{}", "an image"}).find("template 2 'an image' has '{}' 0 times"),
            std::string::npos);
  EXPECT_NE(messageOf({"{} and {}"}).find("2 times, expected once"), std::string::npos);
}

TEST(AverageGroups, EqualsTheNormalisedMeanOfUnitVectors) {
  EmbeddingMatrix embeddings(4, 2);
  embeddings << 3, 0, 0, 0.5F, -2, 0, -7, 0;
  const EmbeddingMatrix means = averageGroups(embeddings, 2);
  ASSERT_EQ(means.rows(), 2);
  EXPECT_TRUE(means.row(0).isApprox(Eigen::RowVector2f(1, 1).normalized()));
  EXPECT_TRUE(means.row(1).isApprox(Eigen::RowVector2f(-1, 0)));
}

TEST(AverageGroups, OfOneIsTheNormalisedRow) {
  const EmbeddingMatrix embeddings = EmbeddingMatrix::Random(5, 7);
  const EmbeddingMatrix means = averageGroups(embeddings, 1);
  for (Eigen::Index i = 0; i < 5; ++i) {
    EXPECT_NEAR(means.row(i).norm(), 1.0F, 1e-6F);
    EXPECT_NEAR(computeCosine(means.row(i), embeddings.row(i)), 1.0, 1e-6);
  }
}

TEST(AverageGroups, RowsThatDoNotDivideAreRefused) {
  EXPECT_THROW(averageGroups(EmbeddingMatrix::Ones(3, 2), 2), std::invalid_argument);
  EXPECT_THROW(averageGroups(EmbeddingMatrix::Ones(3, 2), 0), std::invalid_argument);
  EXPECT_EQ(averageGroups(EmbeddingMatrix(0, 2), 2).rows(), 0);
}

TEST(NormalizeRows, RowOfZerosStays) {
  EXPECT_TRUE(normalizeRows(EmbeddingMatrix::Zero(1, 3)).isZero(0.0F));
}

}  // namespace
}  // namespace tsg::language
